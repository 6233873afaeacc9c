#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slipstream/calibrate/capture_signs.h"

namespace slipstream {

/// One pose of the board: where camera and projector see its corners.
struct BoardView {
  std::string name;                        ///< of the pose's folder
  std::vector<int> places;                 ///< which corner of the board each is
  std::vector<Eigen::Vector2d> camera;     ///< pixels
  std::vector<Eigen::Vector2d> projector;  ///< pixels; NaN where it could not be told
  /// d projector / d camera: a corner that the camera sees a little off was looked for in the
  /// projector's picture a little off too, by as much as this makes of it. Empty, or zero, where
  /// the projector pixels are independent of the camera's.
  std::vector<Eigen::Matrix2d> slopes{};
  CaptureSigns signs{};  ///< how its frames were taken; nothing where there were none
};

/// `slopes` of a corner, zero where there is none.
inline Eigen::Matrix2d slope_at(const BoardView& view, std::size_t corner) {
  return view.slopes.empty() ? Eigen::Matrix2d(Eigen::Matrix2d::Zero()) : view.slopes[corner];
}

/// Corners whose projector pixel is known.
inline int lit_corners(const BoardView& view) {
  int count = 0;
  for (const Eigen::Vector2d& pixel : view.projector) count += pixel.allFinite() ? 1 : 0;
  return count;
}

}  // namespace slipstream
