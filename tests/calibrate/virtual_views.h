#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "calibrate/board_view.h"
#include "slipstream/calibration_board.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// Board poses in front of a scanner, and their corners in camera and projector, exact except for
/// Gaussian noise.
struct VirtualViews {
  std::vector<BoardView> views;
  std::vector<Eigen::Isometry3d> poses;  ///< board frame to camera frame
};

/// `places`: true corners of the printed board, mm.
inline VirtualViews virtual_views(const Scanner& scanner, const CalibrationBoard& board,
                                  const std::vector<Eigen::Vector3d>& places, int count,
                                  double noise_in_pixels, std::uint32_t seed = 1) {
  const double width = (board.columns + 3) * board.spacing;
  const double height = (board.rows + 3) * board.spacing;
  const Eigen::Vector3d middle = places.front() / 2 + places.back() / 2;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1);
  const auto noisy = [&](Eigen::Vector2d pixel) -> Eigen::Vector2d {
    pixel.x() += noise_in_pixels * noise(random);
    pixel.y() += noise_in_pixels * noise(random);
    return pixel;
  };
  VirtualViews result;
  for (Eigen::Isometry3d pose : board_poses(scanner, count, width, height)) {
    pose.translate(-middle);
    BoardView view;
    view.name = "pose" + std::to_string(result.views.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Eigen::Vector3d point = pose * places[i];
      view.places.push_back(static_cast<int>(i));
      view.camera.push_back(noisy(project(scanner.camera, point)));
      view.projector.push_back(
          noisy(project(scanner.projector, in_projector_frame(scanner, point))));
    }
    result.views.push_back(view);
    result.poses.push_back(pose);
  }
  return result;
}

}  // namespace slipstream
