#include "calibrate/first_guess.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/LU>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "base/linear_algebra.h"
#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "calibrate/board_view.h"
#include "calibrate/opencv.h"

namespace slipstream {
namespace {

/// Corners, view by view, in OpenCV's form.
struct SharedCorners {
  std::vector<std::vector<cv::Point3f>> board;
  std::vector<std::vector<cv::Point2f>> camera, projector;
};

cv::Point2f point_of(const Eigen::Vector2d& pixel) {
  return {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
}

SharedCorners corners_seen_by(Device device, const BoardViews& views, const BoardPlaces& printed) {
  SharedCorners shared;
  for (const BoardView& view : views) {
    shared.board.emplace_back();
    shared.camera.emplace_back();
    shared.projector.emplace_back();

    for (std::size_t i = 0; i < view.places.size(); ++i) {
      const bool seen = view.camera[i].allFinite() && corners_of(view, device)[i].allFinite();
      if (!seen) continue;

      const Eigen::Vector3d& place = printed[view.places[i]];
      shared.board.back().emplace_back(static_cast<float>(place.x()), static_cast<float>(place.y()),
                                       0.0F);
      shared.camera.back().push_back(point_of(view.camera[i]));
      shared.projector.back().push_back(point_of(view.projector[i]));
    }
  }

  return shared;
}

/// Rounds to 14 bits, enough for a start. OpenCV's solvers are not reproducible in the last digits:
/// LAPACK's order of summation depends on memory alignment.
double rounded(double value) {
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);
  return std::ldexp(std::round(std::ldexp(mantissa, 14)), exponent - 14);
}

void round_off(cv::Mat& numbers) {
  std::transform(numbers.begin<double>(), numbers.end<double>(), numbers.begin<double>(), rounded);
}

struct OneDevice {
  cv::Mat intrinsic, distortion;
  std::vector<cv::Mat> rotations, translations;
};

OneDevice calibrated(const std::vector<std::vector<cv::Point3f>>& board,
                     const std::vector<std::vector<cv::Point2f>>& pixels, Size size) {
  OneDevice device;

  cv::calibrateCamera(board, pixels, {size.width, size.height}, device.intrinsic, device.distortion,
                      device.rotations, device.translations,
                      cv::CALIB_ZERO_TANGENT_DIST | cv::CALIB_FIX_K3);

  round_off(device.intrinsic);
  round_off(device.distortion);
  for (cv::Mat& turn : device.rotations) round_off(turn);
  for (cv::Mat& translation : device.translations) round_off(translation);
  return device;
}

Lens lens_of(const OneDevice& device, Size size) {
  Lens lens;
  lens.size = size;
  cv::cv2eigen(device.intrinsic, lens.intrinsic);
  std::copy_n(device.distortion.begin<double>(), 5, lens.distortion.coefficients.begin());
  return lens;
}

BundleState guess(const SharedCorners& shared, const BoardPlaces& printed, Size camera_size,
                  Size projector_size) {
  // 1. Each device alone.
  OneDevice camera = calibrated(shared.board, shared.camera, camera_size);
  OneDevice projector = calibrated(shared.board, shared.projector, projector_size);

  // 2. The projector's pose relative to the camera, with both lenses fixed.
  cv::Mat rotation, turn, translation, essential, fundamental;
  cv::stereoCalibrate(shared.board, shared.camera, shared.projector, camera.intrinsic,
                      camera.distortion, projector.intrinsic, projector.distortion,
                      {camera_size.width, camera_size.height}, rotation, translation, essential,
                      fundamental, cv::CALIB_FIX_INTRINSIC);
  cv::Rodrigues(rotation, turn);
  round_off(turn);
  round_off(translation);
  const Eigen::Isometry3d rig = pose_of(turn, translation);

  // 3. Lenses, rig and the boards' poses before the camera.
  BundleState state{{lens_of(camera, camera_size), lens_of(projector, projector_size), rig.linear(),
                     rig.translation()},
                    {},
                    printed};

  for (std::size_t v = 0; v < shared.board.size(); ++v) {
    state.poses.push_back(pose_of(camera.rotations[v], camera.translations[v]));
  }

  return state;
}

/// The A of the best fit: projector pixel = A camera pixel + b.
Eigen::Matrix2d affine_map(const BoardView& view) {
  const int count = lit_corners(view);
  Eigen::MatrixX3d camera(count, 3);
  Eigen::MatrixX2d projector(count, 2);

  int row = 0;
  for (std::size_t i = 0; i < view.camera.size(); ++i) {
    if (!is_lit(view, i)) continue;
    camera.row(row) << view.camera[i].transpose(), 1;
    projector.row(row) = view.projector[i].transpose();
    ++row;
  }

  const Eigen::Matrix<double, 3, 2> solution = least_squares(camera, projector).X;
  return solution.topRows<2>().transpose();
}

void remove_wrong_fringes(BoardView& view, const BoardPlaces& printed) {
  constexpr std::size_t fewest = 6;
  constexpr double reach = 8;

  std::vector<cv::Point2f> board, projector;
  std::vector<std::size_t> corners;

  for (std::size_t i = 0; i < view.places.size(); ++i) {
    if (!view.projector[i].allFinite()) continue;
    const Eigen::Vector3d& place = printed[view.places[i]];
    board.emplace_back(static_cast<float>(place.x()), static_cast<float>(place.y()));
    projector.push_back(point_of(view.projector[i]));
    corners.push_back(i);
  }
  if (corners.size() < fewest) return;

  // RANSAC: whole fringes are many pixels, far beyond the effect of lens distortion.
  cv::Mat inliers;
  const QuietOpenCv quiet;
  cv::findHomography(board, projector, inliers, cv::RANSAC, reach);

  for (std::size_t k = 0; k < corners.size(); ++k) {
    const bool agrees = !inliers.empty() && inliers.at<std::uint8_t>(static_cast<int>(k)) != 0;
    if (!agrees) view.projector[corners[k]] = {nan, nan};
  }
}

void require_same_handedness(const BoardView& view) {
  constexpr int fewest = 4;
  throw_if(lit_corners(view) < fewest,
           "{}: fewer than {} corners are lit and fit one flat board; light the whole board, or "
           "exclude the pose with `excluded`",
           view.name, fewest);

  const Eigen::Matrix2d A = affine_map(view);
  if (A.determinant() > 0) return;

  // Swapped axes have the larger elements off the diagonal, a mirrored picture on it.
  throw_if(A.diagonal().squaredNorm() < A.squaredNorm() / 2,
           "{}: projector x and y are swapped; likely the scans along x and y are exchanged: check "
           "the frame order or `first_axis`",
           view.name);

  throw Error(
      fmt::format("{}: the projector's (or camera's) picture is mirrored along {}; turn off "
                  "mirroring in the device",
                  view.name, A(0, 0) < 0 ? "x" : "y"));
}

}  // namespace

BundleState first_guess(const BoardViews& views, const BoardPlaces& printed, Size camera,
                        Size projector) {
  const QuietOpenCv quiet;
  try {
    return guess(corners_seen_by(Device::projector, views, printed), printed, camera, projector);
  } catch (const cv::Exception& exception) {
    throw Error(fmt::format(
        "OpenCV finds no initial calibration: {}; likely too few tilts of the board, or corners "
        "that are not on one flat board: add tilted poses",
        exception.err));
  }
}

BoardViews checked_views(BoardViews views, const BoardPlaces& printed) {
  for (BoardView& view : views) remove_wrong_fringes(view, printed);
  for (const BoardView& view : views) require_same_handedness(view);
  return views;
}

Lens simple_lens(const BoardViews& views, const BoardPlaces& printed, Size camera) {
  const SharedCorners seen = corners_seen_by(Device::camera, views, printed);
  const QuietOpenCv quiet;
  const cv::Mat found =
      cv::initCameraMatrix2D(seen.board, seen.camera, {camera.width, camera.height}, 1);

  // Boards with little tilt do not determine the focal length.
  const double focal = found.at<double>(0, 0), usual = 1.3 * camera.width;
  const double used = focal > 0.5 * camera.width && focal < 10 * camera.width ? focal : usual;

  Lens lens;
  lens.size = camera;
  lens.intrinsic << used, 0, 0.5 * camera.width, 0, used, 0.5 * camera.height, 0, 0, 1;
  return lens;
}

Eigen::Isometry3d pose_before_camera(const BoardView& view, const Lens& camera,
                                     const BoardPlaces& printed) {
  std::vector<cv::Point3d> board;
  std::vector<cv::Point2d> seen;  // by a camera without distortion and of focal length 1

  for (std::size_t i = 0; i < view.places.size(); ++i) {
    const Eigen::Vector3d& place = printed[view.places[i]];
    const Eigen::Vector3d ray = ray_through(camera, view.camera[i]);
    if (!ray.allFinite()) continue;

    board.emplace_back(place.x(), place.y(), 0);
    seen.emplace_back(ray.x(), ray.y());
  }

  const QuietOpenCv quiet;
  cv::Mat turn, translation;
  try {
    cv::solvePnP(board, seen, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turn, translation);
  } catch (const cv::Exception& exception) {
    throw Error(
        fmt::format("{}: OpenCV finds no pose for its corners: {}; exclude it with `excluded`",
                    view.name, exception.err));
  }

  return pose_of(turn, translation);
}

BundleState boards_before(const Scanner& scanner, const BoardViews& views,
                          const BoardPlaces& printed) {
  BundleState state{scanner, {}, printed};
  for (const BoardView& view : views) {
    state.poses.push_back(pose_before_camera(view, scanner.camera, printed));
  }
  return state;
}

}  // namespace slipstream
