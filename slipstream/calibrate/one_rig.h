#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "slipstream/calibrate/board_view.h"
#include "slipstream/calibrate/bundle_adjustment.h"

namespace slipstream {

inline constexpr std::size_t fewest_poses = 3;

/// A calibration of a simple model, of a board as printed: good enough to build on, and to see
/// whether the poses are of one rig.
BundleState simple_calibration(const std::vector<BoardView>& views,
                               const std::vector<Eigen::Vector3d>& printed, Size camera,
                               Size projector);

/// Throws Error, naming the likely cause, where a pose does not fit the others, or none fits any.
/// `state` is the simple calibration of them all.
void require_one_rig(const std::vector<BoardView>& views, const BundleState& state,
                     const std::vector<Eigen::Vector3d>& printed);

/// Where camera and projector were moved against each other.
struct MovedRig {
  std::size_t first = 0;  ///< pose of the rig as it then stood
  double gain = 1;        ///< mean squared error with one rig, over that with two
};

/// The place in the sequence of poses at which two rigs of the same lenses explain them best. None
/// of less than six poses. `state` is a calibration of them all.
std::optional<MovedRig> moved_rig(const std::vector<BoardView>& views, const BundleState& state);

}  // namespace slipstream
