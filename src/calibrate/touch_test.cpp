#include "calibrate/touch_test.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/throw_if-inl.h"
#include "calibrate/board_view.h"
#include "calibrate/first_guess.h"

namespace slipstream {

namespace {

/// `differences`: camera less robot, mm, in the base frame.
TouchTest test_of(std::vector<Eigen::Vector3d> differences) {
  throw_if(differences.empty(), "such a test needs at least one point");

  TouchTest test{.differences = std::move(differences)};
  const auto count = static_cast<double>(test.differences.size());
  for (const Eigen::Vector3d& difference : test.differences) {
    throw_if(!difference.allFinite(), "point {} is not measured",
             &difference - test.differences.data() + 1);
    test.mean += difference / count;
    test.rms += difference.squaredNorm() / count;
    test.largest = std::max(test.largest, difference.norm());
  }
  test.rms = std::sqrt(test.rms);

  for (const Eigen::Vector3d& difference : test.differences) {
    test.standard_error += (difference - test.mean).cwiseAbs2() / ((count - 1) * count);
  }
  test.standard_error = test.standard_error.cwiseSqrt();
  return test;
}

/// The index in the view of the outer corner of the board nearest to a point, camera frame.
std::size_t nearest_outer_corner(const BoardView& view, const CalibrationBoard& board,
                                 const BoardPlaces& seen, const Eigen::Vector3d& point) {
  const int last = place_count(board) - 1;
  const std::array outer{0, board.columns - 1, last - board.columns + 1, last};
  const int nearest = *std::ranges::min_element(
      outer, {}, [&](int place) { return (seen[static_cast<std::size_t>(place)] - point).norm(); });

  const auto found = std::ranges::find(view.places, nearest);
  const auto index = static_cast<std::size_t>(found - view.places.begin());
  throw_if(found == view.places.end() || !is_lit(view, index),
           "{}: the outer corner beside a point is not in view and lit", view.name);
  return index;
}

}  // namespace

TouchTest touch_test(std::span<const Eigen::Vector3d> points, const Eigen::Isometry3d& camera,
                     std::span<const Eigen::Isometry3d> tools, const Eigen::Vector3d& tip) {
  throw_if(points.size() != tools.size(),
           "there are {} measured points and {} touched ones; give them in the same order",
           points.size(), tools.size());

  std::vector<Eigen::Vector3d> differences;
  for (std::size_t i = 0; i < points.size(); ++i) {
    differences.emplace_back(camera * points[i] - tools[i] * tip);
  }
  return test_of(std::move(differences));
}

TouchTest projection_test(const BoardView& view, const CalibrationBoard& board,
                          const Scanner& scanner, const Eigen::Isometry3d& camera,
                          std::span<const Eigen::Vector3d> points) {
  // 1. The board's plane and corners in the camera's frame.
  const BoardPlaces printed = printed_places(board);
  const Eigen::Isometry3d pose = pose_before_camera(view, scanner.camera, printed);
  const Eigen::Vector3d normal = pose.linear().col(2);
  BoardPlaces seen;
  for (const Eigen::Vector3d& place : printed) seen.emplace_back(pose * place);

  // 2. Where the ray of a projector pixel meets it.
  const Eigen::Matrix3d to_camera = scanner.rotation.transpose();
  const Eigen::Vector3d projector = -to_camera * scanner.translation;
  const auto lit_by = [&](const Eigen::Vector2d& pixel) -> Eigen::Vector3d {
    const Eigen::Vector3d ray = to_camera * ray_through(scanner.projector, pixel);
    return projector + normal.dot(pose.translation() - projector) / normal.dot(ray) * ray;
  };

  // 3. The corner by the light that it was measured in, less the light for the robot's point.
  std::vector<Eigen::Vector3d> differences;
  std::set<std::size_t> corners;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d place = camera.inverse() * point;
    const std::size_t corner = nearest_outer_corner(view, board, seen, place);
    throw_if(!corners.insert(corner).second,
             "{}: two points are nearest to one outer corner of the board; touch each corner once, "
             "and check the hand-eye pose and the tip",
             view.name);

    const Eigen::Vector3d aimed =
        lit_by(project(scanner.projector, in_projector_frame(scanner, place)));
    differences.emplace_back(camera.linear() * (lit_by(view.projector[corner]) - aimed));
  }
  return test_of(std::move(differences));
}

Verdict verdict_of(const TouchTest& test, double tolerance) {
  const double off = test.mean.norm();
  const double error = test.standard_error.allFinite() ? test.standard_error.norm() : 0;
  if (off - 2 * error > tolerance) {
    return {"bad", fmt::format("Calibrate again: the camera measures points off by {}.",
                               signed_text_of(test.mean))};
  }
  if (test.largest > tolerance) {
    return {"usable", fmt::format("Usable: the mean is off by {:.3f} mm, single points by up to "
                                  "{:.3f} mm.",
                                  off, test.largest)};
  }
  return {"good", fmt::format("Good: all points are within {:.3f} mm.", test.largest)};
}

std::string signed_text_of(const Eigen::Vector3d& offset) {
  return fmt::format("{:+.3f} mm in x, {:+.3f} mm in y, {:+.3f} mm in z", offset.x(), offset.y(),
                     offset.z());
}

}  // namespace slipstream
