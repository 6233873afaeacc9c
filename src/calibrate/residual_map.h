#pragma once

#include <cstddef>

#include "calibrate/bundle_adjustment.h"
#include "slipstream/geometry_calibration.h"

namespace slipstream {

/// Degrees of both lenses' residual maps; 0: none.
struct ResidualDegrees {
  int camera = 0, projector = 0;
};

/// bundle_adjusted with residual maps of these degrees, fitted to the corners in turn with the
/// rest.
BundleState adjusted_with_residual(const BoardViews& views, BundleState start,
                                   const BoardPlaces& printed, const BundleSettings& settings,
                                   const ResidualDegrees& degrees,
                                   BundleDeviation* deviation = nullptr);

/// The poses of one fold under a calibration of the other folds: only the fold's boards move then.
/// `state`: start of both adjustments. See fold_count.
SomePoses explained_fold(const BoardViews& views, const BundleState& state, BundleSettings settings,
                         const ResidualDegrees& degrees, std::size_t fold);

/// Chooses the map of one device, the other keeping its degree in `degrees`: fits maps without some
/// of the poses and evaluates them on these, with only the board's pose free. Returns the lowest
/// degree that is not clearly worse than the best. `state`: start of the adjustments. Throws Error
/// for too few poses.
ResidualChoice chosen_residual(const BoardViews& views, const BundleState& state,
                               const BundleSettings& settings, Device device,
                               const ResidualDegrees& degrees);

}  // namespace slipstream
