#include "slipstream/scanner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <variant>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <unsupported/Eigen/AutoDiff>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "geometry/lens_residual.h"

namespace slipstream {
namespace {

template <class Number>
using Vector2 = Eigen::Matrix<Number, 2, 1>;

template <class Number>
Vector2<Number> distort_generic(const Distortion& distortion, const Vector2<Number>& direction) {
  const double tau_x = distortion.coefficients[12], tau_y = distortion.coefficients[13];

  const Vector2<Number> bent = distort_untilted(distortion.coefficients.data(), direction);
  if (tau_x == 0 && tau_y == 0) return bent;

  const Eigen::Matrix3d tilt = sensor_tilt(tau_x, tau_y);
  const auto row = [&](int i) -> Number {
    return tilt(i, 0) * bent.x() + tilt(i, 1) * bent.y() + tilt(i, 2);
  };
  const Number depth = row(2);
  return {row(0) / depth, row(1) / depth};
}

/// A direction after the lens, and how it changes with the direction before.
struct Bent {
  Eigen::Vector2d direction;
  Eigen::Matrix2d jacobian;
};

Bent bent(const Distortion& distortion, const Eigen::Vector2d& direction) {
  // Automatic differentiation: u and v each carry their derivative.
  using Dual = Eigen::AutoDiffScalar<Eigen::Vector2d>;
  const Vector2<Dual> bent =
      distort_generic<Dual>(distortion, {Dual(direction.x(), 2, 0), Dual(direction.y(), 2, 1)});

  Eigen::Matrix2d jacobian;
  jacobian << bent.x().derivatives().transpose(), bent.y().derivatives().transpose();

  return {{bent.x().value(), bent.y().value()}, jacobian};
}

void require_size(const Lens& lens, std::string_view device) {
  throw_if(lens.size.width < 1 || lens.size.height < 1,
           "{}: size {} is empty; set it in the scanner file or with a flag", device,
           text_of(lens.size));
}

/// K [R T] of a perspective matrix.
struct Posed {
  Eigen::Matrix3d intrinsic, rotation;
  Eigen::Vector3d translation;
};

Posed posed(const Eigen::Matrix<double, 3, 4>& matrix, std::string_view device) {
  const Eigen::Matrix3d left = matrix.leftCols<3>();
  constexpr double least = 1e-14;  // of the matrix: rounding

  // K R = left, with K upper triangular and R orthogonal, by Gram-Schmidt from the last row up. The
  // focal lengths come out positive.
  Eigen::Matrix3d K = Eigen::Matrix3d::Zero(), R = K;
  for (int row = 2; row >= 0; --row) {
    Eigen::Vector3d rest = left.row(row);
    for (int below = 2; below > row; --below) {
      K(row, below) = R.row(below).dot(left.row(row));
      rest -= K(row, below) * R.row(below).transpose();
    }

    K(row, row) = rest.norm();
    throw_if(!(K(row, row) > least * matrix.norm()),
             "{}: the projection matrix is singular or not finite", device);
    R.row(row) = rest / K(row, row);
  }

  Eigen::Vector3d T = K.triangularView<Eigen::Upper>().solve(matrix.col(3));
  if (R.determinant() < 0) {  // the matrix is known only up to its sign
    R = -R;
    T = -T;
  }

  return {K / K(2, 2), R, T};
}

}  // namespace

Distortion make_distortion(std::span<const double> coefficients) {
  constexpr std::array<std::size_t, 6> known_counts{0, 4, 5, 8, 12, 14};
  throw_if(std::ranges::find(known_counts, coefficients.size()) == known_counts.end(),
           "{} distortion coefficients; expected 0, 4, 5, 8, 12 or 14", coefficients.size());

  Distortion distortion;
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    throw_if(!std::isfinite(coefficients[i]), "distortion coefficient {} is {}; it must be finite",
             i, coefficients[i]);
    distortion.coefficients[i] = coefficients[i];
  }

  return distortion;
}

void require_valid(const Lens& lens, std::string_view device) {
  const Eigen::Matrix3d& K = lens.intrinsic;
  const bool camera_matrix = K.allFinite() && K(0, 0) > 0 && K(1, 1) > 0 && K(1, 0) == 0 &&
                             K(2, 0) == 0 && K(2, 1) == 0 && K(2, 2) == 1;
  throw_if(!camera_matrix,
           "{}: invalid camera matrix; expected [fx s cx; 0 fy cy; 0 0 1] with fx, fy > 0", device);
  require_valid(lens.residual, device);
}

Eigen::Matrix3d sensor_tilt(double tau_x, double tau_y) {
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(-tau_y, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(-tau_x, Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();

  // Projects the turned direction onto the tilted sensor, as in OpenCV.
  Eigen::Matrix3d onto_sensor;
  onto_sensor << R(2, 2), 0, -R(0, 2), 0, R(2, 2), -R(1, 2), 0, 0, 1;

  return onto_sensor * R;
}

Eigen::Vector2d distort(const Distortion& distortion, const Eigen::Vector2d& direction) {
  return distort_generic<double>(distortion, direction);
}

Eigen::Vector2d undistort(const Distortion& distortion, const Eigen::Vector2d& distorted) {
  if (distortion.is_zero()) return distorted;
  constexpr int most_iterations = 60;
  constexpr double tolerance = 1e-15, small = 1e-6;

  Eigen::Vector2d direction = distorted, step = {0, 0};
  double farthest = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const auto [image, jacobian] = bent(distortion, direction);
    const double apart = (image - distorted).norm();

    // Newton's method; where it would leave the part that is invertible, with shorter steps, and
    // from the middle if it begins outside.
    if (!(jacobian.determinant() > 0) || !(apart < farthest || step.norm() < small)) {
      if (iteration == 0) {
        direction.setZero();
      } else {
        direction += step /= 2;
      }
      continue;
    }

    farthest = apart;
    step = jacobian.inverse() * (image - distorted);
    direction -= step;
    if (step.lpNorm<Eigen::Infinity>() <= tolerance * (1 + direction.lpNorm<Eigen::Infinity>())) {
      return direction;
    }
  }
  return {nan, nan};
}

std::optional<double> largest_tangent(const Lens& lens, const Eigen::Vector2d& margin) {
  constexpr int rays = 96, steps = 48;
  constexpr double steepest = 20;
  const Eigen::Array2d size(lens.size.width, lens.size.height);

  // Place in the picture, 0 to 1 across its width and height.
  const auto place = [&](const Eigen::Vector2d& image) -> Eigen::Array2d {
    return (lens.intrinsic * image.homogeneous()).head<2>().array() / size;
  };

  // 1. The corners of the picture with its margin. fmax ignores a corner without an inverse.
  double largest = 0;
  for (const auto& [x, y] : {std::pair(0, 0), std::pair(0, 1), std::pair(1, 0), std::pair(1, 1)}) {
    const Eigen::Array2d corner = Eigen::Array2d(x, y) * (1 + 2 * margin.array()) - margin.array();
    largest = std::fmax(largest, ray_through(lens, (corner * size).matrix()).head<2>().norm());
  }
  if (largest == 0) return std::nullopt;

  // The axis may lie beside the picture.
  const Eigen::Array2d axis = place({0, 0});
  const Eigen::Array2d low = axis.min(-margin.array()), high = axis.max(1 + margin.array());

  // 2. Rays outwards from the axis, until their images leave the picture: on the way, the model
  //    must not turn back.
  const double longest_step = largest / steps;

  for (int i = 0; i < rays; ++i) {
    const double angle = 2 * std::numbers::pi * i / rays;
    const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
    for (double r = 0;;) {
      const auto [image, jacobian] = bent(lens.distortion, r * along);

      const Eigen::Array2d at = place(image);
      if ((at < low).any() || (at > high).any()) break;

      const double area = jacobian.determinant();
      if (!(area > 0) || r > steepest) return std::nullopt;

      // A fold narrower than a step begins with a small area.
      r += longest_step * std::clamp(area, 0.05, 1.0);
      largest = std::max(largest, r);
    }
  }

  return largest;
}

Eigen::Vector2d project(const Lens& lens, const Eigen::Vector3d& point) {
  const Eigen::Vector2d bent = distort(lens.distortion, point.hnormalized());
  return shifted_by(lens.residual, (lens.intrinsic * bent.homogeneous()).head<2>());
}

Eigen::Vector3d ray_through(const Lens& lens, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d ideal = pixel - shift_at(lens.residual, pixel);
  const Eigen::Vector2d bent =
      lens.intrinsic.triangularView<Eigen::Upper>().solve(ideal.homogeneous()).head<2>();
  return undistort(lens.distortion, bent).homogeneous();
}

Image<PixelPosition> undistorted_pixels(const Lens& lens) {
  Image<PixelPosition> positions(lens.size);
  for_each_pixel(lens.size, [&](int column, int row) {
    const Eigen::Vector3d ideal = lens.intrinsic * ray_through(lens, {column, row});
    positions(column, row) = {ideal.x(), ideal.y()};
  });
  return positions;
}

Lens part_of(Lens lens, const Rectangle& part) {
  const Size all = lens.size;
  const bool is_inside =
      part.x >= 0 && part.y >= 0 && part.size.width > 0 && part.size.height > 0 &&
      (all == Size{} ||
       (part.x <= all.width - part.size.width && part.y <= all.height - part.size.height));
  throw_if(!is_inside, "camera region {}+{}+{} is not a part of pictures of {}", text_of(part.size),
           part.x, part.y, text_of(all));

  lens.intrinsic(0, 2) -= part.x;
  lens.intrinsic(1, 2) -= part.y;
  lens.residual.centre -= Eigen::Vector2d(part.x, part.y);
  lens.size = part.size;
  return lens;
}

Scanner without_geometry(Size camera, Size projector, const PhotometricCalibration& known) {
  Scanner scanner{.photometry = known};
  scanner.camera.size = camera;
  scanner.projector.size = projector;
  return scanner;
}

void require_valid(const Scanner& scanner) {
  // Lenses.
  require_valid(scanner.camera, "camera");
  require_valid(scanner.projector, "projector");
  require_size(scanner.camera, "camera");
  require_size(scanner.projector, "projector");

  // Pose.
  const Eigen::Matrix3d& R = scanner.rotation;
  throw_if(!(R.allFinite() && R.determinant() > 0 && (R.transpose() * R).isIdentity(1e-4)),
           "rotation: the matrix is not a rotation; its rows must be orthonormal");
  throw_if(!scanner.translation.allFinite(),
           "translation: a value is not finite; expected the camera's position in the projector's "
           "frame, mm");
  throw_if(scanner.translation.norm() < 1e-9,
           "baseline 0 mm: camera and projector at one position give no depth; check "
           "the translation");

  // Light and depths.
  require_valid(scanner.photometry);
  throw_if(!(scanner.calibration_rms >= 0 && std::isfinite(scanner.calibration_rms)),
           "calibration_rms {} is out of range; 0 or more pixels", scanner.calibration_rms);

  const auto& depths = scanner.calibrated_depths;
  if (depths && !(depths->nearest >= 0 && depths->nearest < depths->farthest)) {
    throw Error(fmt::format("calibrated_depths {} to {} are out of range; 0 or more, nearest first",
                            depths->nearest, depths->farthest));
  }
}

void require_valid(const PhotometricCalibration& photometry) {
  require_in_range(photometry);

  if (!photometry.response) return;
  if (const auto* law = std::get_if<PowerLaw>(&photometry.response->response)) {
    require_gamma(law->gamma, "gamma");
  }
}

double noise_variance_at(double grey_level, double at_half, double gain) {
  return std::max(at_half + gain * (grey_level - 127.5), at_half / 20);
}

Scanner completed(Scanner scanner, const std::string& file, Size camera, Size projector) {
  const auto complete = [&](Size& known, Size other, std::string_view device, std::string_view by) {
    if (known.width == 0 || known.height == 0) known = other;
    throw_if(other != Size{} && known != other, "{}: the {} has {}, but {} {}; both must match",
             file, device, text_of(known), by, text_of(other));
  };

  complete(scanner.camera.size, camera, "camera", "the frames are");
  complete(scanner.projector.size, projector, "projector", "the patterns are for");

  throw_if(scanner.projector.size == Size{},
           "{}: the projector size is missing; set it with `projector`", file);

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

  // From the camera's frame to the projector's, by way of the world's.
  const Eigen::Matrix3d rotation = second.rotation * first.rotation.transpose();

  return {.camera = {.intrinsic = first.intrinsic, .distortion = {}, .size = camera_size},
          .projector = {.intrinsic = second.intrinsic, .distortion = {}, .size = projector_size},
          .rotation = rotation,
          .translation = second.translation - rotation * first.translation};
}

void require_depth_visible(const Scanner& scanner, Axis axis) {
  // Stripes are planes through the projector's centre, along the other axis of its image. The
  // camera must not lie on the line common to all of them.
  const Eigen::Vector3d& T = scanner.translation;
  const double across_stripes = std::hypot(axis == Axis::x ? T.x() : T.y(), T.z());
  throw_if(across_stripes < 1e-6 * T.norm(),
           "the baseline is parallel to the stripes of axis {0}, which give no depth: use axis {1}",
           name_of(axis), name_of(across(axis)));
}

}  // namespace slipstream
