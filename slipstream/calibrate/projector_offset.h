#pragma once

#include <vector>

#include <Eigen/Core>

#include "slipstream/calibrate/board_view.h"
#include "slipstream/calibrate/bundle_adjustment.h"

namespace slipstream {

/// Where the projector sees a board's corners, against where it should if the board stands where
/// the camera alone sees it: projector pixels.
struct ProjectorOffset {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double spread = 0;  ///< RMS about the mean, of both components together

  friend bool operator==(const ProjectorOffset&, const ProjectorOffset&) = default;
};

/// Of a view before a scanner that it took no part in calibrating. `start`: about where its board
/// stands. NaN where no corner is lit.
ProjectorOffset projector_offset(const BoardView& view, const Scanner& scanner,
                                 const Eigen::Isometry3d& start,
                                 const std::vector<Eigen::Vector3d>& places);

}  // namespace slipstream
