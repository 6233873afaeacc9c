#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace slipstream {

/// Points of a board in one pose, as another program found them: three lists of equal length.
struct PosePoints {
  std::string name;
  std::vector<Eigen::Vector3d> board;      ///< in the board's own frame, in its unit
  std::vector<Eigen::Vector2d> camera;     ///< pixels; NaN if not found
  std::vector<Eigen::Vector2d> projector;  ///< pixels; NaN if not found
};

}  // namespace slipstream
