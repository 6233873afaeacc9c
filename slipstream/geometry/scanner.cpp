#include "slipstream/geometry/scanner.h"

#include <cmath>
#include <string_view>
#include <variant>

#include <Eigen/LU>
#include <Eigen/QR>
#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

void require_size(const Lens& lens, std::string_view device) {
  if (lens.size.width < 1 || lens.size.height < 1) {
    throw Error(fmt::format("{}: size {} is empty; the scanner file or a flag must say it", device,
                            text_of(lens.size)));
  }
}

/// K [R T] of a perspective matrix.
struct Posed {
  Eigen::Matrix3d intrinsic, rotation;
  Eigen::Vector3d translation;
};

Posed posed(const Eigen::Matrix<double, 3, 4>& matrix, std::string_view device) {
  const Eigen::Matrix3d left = matrix.leftCols<3>();
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(left);
  if (!matrix.allFinite() || !lu.isInvertible()) {
    throw Error(fmt::format("{}: its projection matrix is not one of a camera", device));
  }
  // K R = left: with the rows and columns of both turned around it is an orthogonal times an upper
  // triangular matrix of the transpose.
  const Eigen::Matrix3d turned = left.colwise().reverse().transpose();
  const Eigen::HouseholderQR<Eigen::Matrix3d> qr(turned);
  const Eigen::Matrix3d upper = qr.matrixQR().triangularView<Eigen::Upper>();
  const Eigen::Matrix3d orthogonal = qr.householderQ();
  Eigen::Matrix3d K = upper.transpose().reverse();
  Eigen::Matrix3d R = orthogonal.transpose().colwise().reverse();
  const Eigen::Vector3d signs = K.diagonal().cwiseSign();
  K = (K * signs.asDiagonal()).eval();
  R = (signs.asDiagonal() * R).eval();
  Eigen::Vector3d T = K.triangularView<Eigen::Upper>().solve(matrix.col(3));
  if (R.determinant() < 0) {  // the matrix is known up to its sign
    R = -R;
    T = -T;
  }
  const Eigen::Matrix3d intrinsic = K.triangularView<Eigen::Upper>();
  return {intrinsic / K(2, 2), R, T};
}

}  // namespace

bool has_geometry(const Scanner& scanner) {
  return !(scanner.translation.isZero(0) && scanner.camera.intrinsic.isIdentity(0));
}

Scanner without_geometry(Size camera, Size projector, const PhotometricCalibration& known) {
  Scanner scanner{.photometry = known};
  scanner.camera.size = camera;
  scanner.projector.size = projector;
  return scanner;
}

void require_valid(const Scanner& scanner) {
  require_valid(scanner.camera, "camera");
  require_valid(scanner.projector, "projector");
  require_size(scanner.camera, "camera");
  require_size(scanner.projector, "projector");
  const Eigen::Matrix3d& R = scanner.rotation;
  const bool rotation =
      R.allFinite() && R.determinant() > 0 && (R.transpose() * R).isIdentity(1e-4);
  if (!rotation) {
    throw Error("rotation: the matrix is not a rotation; its rows must be orthonormal");
  }
  if (!scanner.translation.allFinite()) {
    throw Error(
        "translation: a value is not finite; it is the camera's place in the projector's "
        "frame, mm");
  }
  if (scanner.translation.norm() < 1e-9) {
    throw Error(
        "baseline 0 mm: camera and projector stand in one place and see no depth; check "
        "the translation");
  }
  require_valid(scanner.photometry);
  if (const auto& depths = scanner.calibrated_depths) {
    if (!(depths->nearest >= 0 && depths->nearest < depths->farthest)) {
      throw Error(fmt::format("calibrated_depths {} to {} are out of range; 0 or more, rising",
                              depths->nearest, depths->farthest));
    }
  }
}

void require_valid(const PhotometricCalibration& photometry) {
  const auto& [ambient, noise_variance, noise_gain, response, mixture] = photometry;
  constexpr double full_scale = 255;
  if (ambient) {
    require_in_range(std::abs(*ambient) <= full_scale, "ambient_light", *ambient,
                     "-255 to 255 grey levels");
  }
  if (noise_variance) {
    require_in_range(*noise_variance > 0 && *noise_variance <= full_scale * full_scale,
                     "noise_variance", *noise_variance, "above 0, at most 255^2");
  }
  require_in_range(noise_gain >= 0 && noise_gain <= full_scale, "noise_gain", noise_gain,
                   "0 to 255");
  if (!response) return;
  if (const auto* law = std::get_if<PowerLaw>(&response->response)) {
    require_gamma(law->gamma, "gamma");
  }
}

double noise_variance_at(double grey_level, double at_half, double gain) {
  return std::max(at_half + gain * (grey_level - 127.5), at_half / 20);
}

Scanner completed(Scanner scanner, const std::string& file, Size camera, Size projector) {
  const auto complete = [&](Size& known, Size said, std::string_view device, std::string_view by) {
    if (known.width == 0 || known.height == 0) known = said;
    if (said != Size{} && known != said) {
      throw Error(fmt::format("{}: its {} has {}, but {} {}; both must agree", file, device,
                              text_of(known), by, text_of(said)));
    }
  };
  complete(scanner.camera.size, camera, "camera", "the frames are");
  complete(scanner.projector.size, projector, "projector", "the patterns are for");
  if (scanner.projector.size == Size{}) {
    throw Error(fmt::format("{}: says no projector size; give it with --projector", file));
  }
  try {
    require_valid(scanner);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", file, error.what()));
  }
  return scanner;
}

Scanner scanner_of(const Eigen::Matrix<double, 3, 4>& camera, Size camera_size,
                   const Eigen::Matrix<double, 3, 4>& projector, Size projector_size) {
  const Posed first = posed(camera, "camera"), second = posed(projector, "projector");
  const Eigen::Matrix3d rotation = second.rotation * first.rotation.transpose();
  return {.camera = {.intrinsic = first.intrinsic, .distortion = {}, .size = camera_size},
          .projector = {.intrinsic = second.intrinsic, .distortion = {}, .size = projector_size},
          .rotation = rotation,
          .translation = second.translation - rotation * first.translation};
}

void require_depth_visible(const Scanner& scanner, Axis axis) {
  // Stripes of constant coordinate are planes through the projector's centre that contain the other
  // axis of its picture. The camera must lie off the line that all of them share.
  const Eigen::Vector3d& T = scanner.translation;
  const double across_stripes = std::hypot(axis == Axis::x ? T.x() : T.y(), T.z());
  if (across_stripes < 1e-6 * T.norm()) {
    throw Error(fmt::format(
        "the baseline runs along the stripes of axis {0}; they show no depth: project along {1}",
        name_of(axis), name_of(across(axis))));
  }
}

Eigen::Vector3d in_projector_frame(const Scanner& scanner, const Eigen::Vector3d& point) {
  return scanner.rotation * point + scanner.translation;
}

Eigen::Vector3d projector_centre(const Scanner& scanner) {
  return -scanner.rotation.transpose() * scanner.translation;
}

double coordinate_along(Axis axis, const Eigen::Vector2d& pixel, Size projector) {
  const double position = axis == Axis::x ? pixel.x() : pixel.y();
  return position / length_along(axis, projector);
}

}  // namespace slipstream
