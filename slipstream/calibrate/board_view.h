#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace slipstream {

/// One pose of the board: where camera and projector see its corners.
struct BoardView {
  std::string name;                        ///< of the pose's folder
  std::vector<int> places;                 ///< which corner of the board each is
  std::vector<Eigen::Vector2d> camera;     ///< pixels
  std::vector<Eigen::Vector2d> projector;  ///< pixels; NaN where it could not be told
};

/// Corners whose projector pixel is known.
inline int lit_corners(const BoardView& view) {
  int count = 0;
  for (const Eigen::Vector2d& pixel : view.projector) count += pixel.allFinite() ? 1 : 0;
  return count;
}

}  // namespace slipstream
