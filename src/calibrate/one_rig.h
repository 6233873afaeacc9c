#pragma once

#include <optional>

#include "slipstream/geometry_calibration.h"

namespace slipstream {

/// `view`: not used to calibrate `scanner`. `start`: approximate pose of its board. NaN if no
/// corner is lit.
ProjectorOffset projector_offset(const BoardView& view, const Scanner& scanner,
                                 const Eigen::Isometry3d& start, const BoardPlaces& places);

/// A calibration with a simple lens model and the nominal board: a start for further steps, and
/// enough to check that all poses are of one rig.
BundleState simple_calibration(const BoardViews& views, const BoardPlaces& printed, Size camera,
                               Size projector);

/// Throws Error with the likely cause if a pose does not fit the others, or none do. `state`: the
/// simple calibration of all poses.
void require_one_rig(const BoardViews& views, const BundleState& state, const BoardPlaces& printed);

/// The pose at which splitting the sequence into two rigs with the same lenses explains it best.
/// nullopt for fewer than six poses. `state`: a calibration of all poses.
std::optional<MovedRig> moved_rig(const BoardViews& views, const BundleState& state);

}  // namespace slipstream
