#include "calibrate/marker_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include <opencv2/calib3d.hpp>

#include "base/linear_algebra.h"
#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "calibrate/charuco.h"
#include "calibrate/opencv.h"
#include "geometry/rotation.h"

namespace slipstream {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

struct Family {
  std::string_view name;
  int dictionary;  ///< OpenCV's
};

constexpr std::array<Family, 8> families{
    {{"36h11", cv::aruco::DICT_APRILTAG_36h11},
     {"36h10", cv::aruco::DICT_APRILTAG_36h10},
     {"25h9", cv::aruco::DICT_APRILTAG_25h9},
     {"16h5", cv::aruco::DICT_APRILTAG_16h5},
     {"4x4", cv::aruco::DICT_4X4_1000},
     {"5x5", cv::aruco::DICT_5X5_1000},
     {"6x6", cv::aruco::DICT_6X6_1000},
     {"7x7", cv::aruco::DICT_7X7_1000}}};  // in the order of Markers

cv::aruco::ArucoDetector detector_of(Markers markers) {
  return slipstream::detector_of(families.at(static_cast<std::size_t>(markers)).dictionary);
}

/// The corners of a square, in the order of SeenMarker::corners.
std::array<Eigen::Vector3d, 4> square_corners(double side) {
  const double half = side / 2;
  return {{{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}}};
}

/// A point of the picture on one of the marker's sides.
struct EdgePoint {
  Eigen::Vector3d place;    ///< on the marker, mm
  Eigen::Vector2d outward;  ///< unit vector across the side
  double distance;          ///< of the edge in the picture from the place, outward, pixels
};

/// Grey level between pixels; NaN outside the picture.
double level_at(const Image<float>& picture, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d floor = pixel.array().floor();
  const int column = static_cast<int>(floor.x()), row = static_cast<int>(floor.y());
  if (column < 0 || row < 0 || column + 1 >= picture.width() || row + 1 >= picture.height()) {
    return nan;
  }

  const Eigen::Vector2d share = pixel - floor;
  const double upper = std::lerp(picture(column, row), picture(column + 1, row), share.x());
  const double lower = std::lerp(picture(column, row + 1), picture(column + 1, row + 1), share.x());
  return std::lerp(upper, lower, share.y());
}

/// Distance along `outward` from the pixel to the edge between dark and bright: the mean place of
/// the change of level, within `reach`, pixels. NaN outside the picture or if it does not brighten.
double edge_distance(const Image<float>& picture, const Eigen::Vector2d& pixel,
                     const Eigen::Vector2d& outward, double reach) {
  constexpr double step = 0.5;          // pixels
  constexpr double least_contrast = 8;  // grey levels
  double before = level_at(picture, pixel - reach * outward);
  double weights = 0, sum = 0;

  for (double at = step - reach; at <= reach; at += step) {
    const double level = level_at(picture, pixel + at * outward);
    weights += level - before;
    sum += (level - before) * (at - step / 2);
    before = level;
  }
  return weights > least_contrast ? sum / weights : nan;
}

/// Points on all four sides, a pixel apart, as the pose predicts them.
std::vector<EdgePoint> edge_points(const Eigen::Isometry3d& pose, double side, int cells,
                                   const Image<float>& picture, const Lens& lens) {
  constexpr double margin = 0.1;      // of a side, at its ends
  constexpr double farthest = 4;      // pixels from the edge
  constexpr double half_cell = 0.45;  // the next edge is a cell away
  constexpr double least_cell = 3;    // pixels
  const std::array<Eigen::Vector3d, 4> corners = square_corners(side);
  std::vector<EdgePoint> points;

  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d from = corners[i], to = corners[(i + 1) % 4];
    const Eigen::Vector3d cell = -(from + to) / cells;  // inward
    const double length = (project(lens, pose * to) - project(lens, pose * from)).norm();

    for (double at = margin * length; at < (1 - margin) * length; ++at) {
      const Eigen::Vector3d place = from + at / length * (to - from);
      const Eigen::Vector2d pixel = project(lens, pose * place);
      const Eigen::Vector2d across = pixel - project(lens, pose * (place + cell));
      const double width = across.norm();
      throw_if(!(width >= least_cell),
               "its bits are {:.1f} pixels wide; {:g} are needed: come closer or print it larger",
               width, least_cell);

      const Eigen::Vector2d outward = across / width;
      const double distance =
          edge_distance(picture, pixel, outward, std::min(farthest, half_cell * width));
      if (std::isfinite(distance)) points.push_back({place, outward, distance});
    }
  }
  return points;
}

/// The pose turned in its own frame and moved in the other.
Eigen::Isometry3d turned_and_moved(const Eigen::Isometry3d& pose, const Vector6& by) {
  return pose_from(pose.linear() * rotation_of_vector(by.head<3>()),
                   pose.translation() + by.tail<3>());
}

/// The change of the edge point's distance with the pose.
Vector6 distance_by_pose(const EdgePoint& point, const Eigen::Isometry3d& pose, double side,
                         const Lens& lens) {
  Vector6 by;
  for (int i = 0; i < 6; ++i) {
    Vector6 change = Vector6::Zero();
    change[i] = i < 3 ? 1e-4 : 1e-4 * side;
    const Eigen::Vector2d more = project(lens, turned_and_moved(pose, change) * point.place);
    const Eigen::Vector2d less = project(lens, turned_and_moved(pose, -change) * point.place);
    by[i] = point.outward.dot(more - less) / (2 * change[i]);
  }
  return by;
}

/// The pose that fits the sides best, from a near one.
MarkerPose pose_on_edges(const Eigen::Isometry3d& start, double side, int cells,
                         const Image<float>& picture, const Lens& lens) {
  constexpr int rounds = 6;
  constexpr std::size_t fewest = 40;  // points on the sides
  MarkerPose result{.pose = start};

  for (int round = 0; round < rounds; ++round) {
    // 1. The edges beside the sides of the pose so far, without the few that something covers.
    std::vector<EdgePoint> points = edge_points(result.pose, side, cells, picture, lens);
    throw_if(points.size() < fewest, "its sides are not visible");

    // 2. A step of least squares.
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Vector6 right = Vector6::Zero();
    double squares = 0;
    for (const EdgePoint& point : points) {
      const Vector6 by = distance_by_pose(point, result.pose, side, lens);
      normal += by * by.transpose();
      right += by * point.distance;
      squares += point.distance * point.distance;
    }
    const auto inverse = inverse_of_symmetric(normal, 0);
    throw_if(!inverse, "its sides do not determine its pose");
    result.pose = turned_and_moved(result.pose, *inverse * right);

    // 3. Neighbours share pixels, and their errors beat with the grid: every fourth distance is
    // independent, as measured in 20 virtual poses.
    constexpr double shared = 4;
    const double variance = squares / static_cast<double>(points.size() - 6);
    const Vector6 deviation = (shared * variance * inverse->diagonal()).cwiseSqrt();
    result.rotation_deviation = deviation.head<3>();
    result.translation_deviation = deviation.tail<3>();
    result.rms = std::sqrt(squares / static_cast<double>(points.size()));
  }
  return result;
}

/// Both poses of a square that has these corners, the better first.
std::vector<Eigen::Isometry3d> poses_of_square(const PixelPlaces& corners, double side,
                                               const Lens& lens) {
  std::vector<cv::Point3d> printed;
  std::vector<cv::Point2d> rays;
  for (const Eigen::Vector3d& corner : square_corners(side)) {
    const Eigen::Vector3d ray = ray_through(lens, corners[printed.size()]);
    printed.emplace_back(corner.x(), corner.y(), 0);
    rays.emplace_back(ray.x(), ray.y());
  }

  std::vector<cv::Mat> turns, translations;
  cv::solvePnPGeneric(printed, rays, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turns, translations,
                      false, cv::SOLVEPNP_IPPE);
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i < turns.size(); ++i)
    poses.push_back(pose_of(turns[i], translations[i]));
  return poses;
}

}  // namespace

std::string_view name_of(Markers markers) {
  return families.at(static_cast<std::size_t>(markers)).name;
}

Markers markers_named(std::string_view name) {
  const auto found = std::ranges::find(families, name, &Family::name);
  if (found != families.end()) return static_cast<Markers>(found - families.begin());
  throw Error(fmt::format(
      "markers '{}': expected 36h11, 36h10, 25h9 or 16h5 of AprilTag, or 4x4 to 7x7 of ArUco",
      name));
}

Image<std::uint8_t> draw_marker(Markers markers, int number, int pixels_per_cell) {
  const cv::aruco::ArucoDetector detector = detector_of(markers);
  throw_if(number < 0 || number >= detector.getDictionary().bytesList.rows,
           "{} has no marker {}; its numbers are 0 to {}", name_of(markers), number,
           detector.getDictionary().bytesList.rows - 1);
  const cv::Mat cells = marker_cells(detector.getDictionary(), number);

  cv::Mat whole, picture;
  cv::copyMakeBorder(cells, whole, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(255));
  cv::resize(whole, picture, {}, pixels_per_cell, pixels_per_cell, cv::INTER_NEAREST);
  return image_from<std::uint8_t>(picture);
}

std::vector<SeenMarker> find_markers(Markers markers, const Image<float>& picture) {
  const QuietOpenCv quiet;
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> numbers;
  detector_of(markers).detectMarkers(stretched(mat_of(picture)), corners, numbers);

  std::vector<SeenMarker> seen;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    seen.push_back({numbers[i], {}});
    for (const cv::Point2f& corner : corners[i])
      seen.back().corners.emplace_back(corner.x, corner.y);
  }
  return seen;
}

MarkerPose marker_pose(Markers markers, const SeenMarker& marker, double side,
                       const Image<float>& picture, const Lens& lens) {
  constexpr double largest_rms = 0.5;                  // pixels
  constexpr double similar = 1.2, apart = 3 * degree;  // ratio of the RMS, angle
  throw_if(!(side > 0) || !std::isfinite(side), "marker side {} mm is out of range; more than 0",
           side);
  const QuietOpenCv quiet;

  const int cells = detector_of(markers).getDictionary().markerSize + 2;
  std::vector<MarkerPose> poses;
  for (const Eigen::Isometry3d& start : poses_of_square(marker.corners, side, lens)) {
    try {
      poses.push_back(pose_on_edges(start, side, cells, picture, lens));
    } catch (const Error&) {
      if (poses.empty()) throw;  // the square's other pose need not be near the edges
    }
  }

  std::ranges::sort(poses, {}, &MarkerPose::rms);
  throw_if(poses.empty() || !(poses.front().rms < largest_rms),
           "its sides are not those of a square; likely a bent or covered marker, or a wrong lens");

  const MarkerPose& best = poses.front();
  throw_if(poses.size() > 1 && poses[1].rms < similar * best.rms &&
               angle_between(best.pose.linear(), poses[1].pose.linear()) > apart,
           "two poses fit it equally well, turned by {:.0f} degrees; come closer, or tilt it more",
           angle_between(best.pose.linear(), poses[1].pose.linear()) / degree);
  return best;
}

}  // namespace slipstream
