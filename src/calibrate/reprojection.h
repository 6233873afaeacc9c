#pragma once

#include <functional>
#include <optional>

#include "base/statistics.h"
#include "calibrate/board_view.h"
#include "slipstream/geometry_calibration.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// Standard deviations of the residuals' components, pixels; the projector's without the part that
/// the camera's errors cause (BoardView::slopes).
struct PixelDeviations {
  double camera = 1;
  double projector = 1;
};

PixelDeviations pixel_deviations(const BoardViews& views, const BundleState& state);

/// Mean squared residual per corner, over all views and both devices, in units of the variances of
/// bundle_adjusted: 4 if `deviations` are right.
double mean_squared_error(const BoardViews& views, const BundleState& state,
                          const PixelDeviations& deviations);

/// A subset of the poses and their state.
struct SomePoses {
  BoardViews views;
  BundleState state;
};

/// The poses whose index `takes` accepts.
SomePoses some_poses(const BoardViews& views, const BundleState& state,
                     const std::function<bool(std::size_t pose)>& takes);

/// Observed minus predicted pixel of each corner of a view, which is pose `v` of the state; NaN if
/// the device does not see the corner.
PixelPlaces residuals(const BoardView& view, const BundleState& state, std::size_t v,
                      Device device);

/// The same distances, squared.
struct Reprojection {
  Squares camera, projector;

  [[nodiscard]] ReprojectionRms rms() const;
};

/// `view` is pose `v` of the state.
Reprojection reprojection(const BoardView& view, const BundleState& state, std::size_t v);
/// The sum over all poses.
Reprojection reprojection(const BoardViews& views, const BundleState& state);

/// Returns nullopt if fewer than four corners are lit.
std::optional<BoardQuality> board_quality(const BoardView& view, const Scanner& scanner,
                                          const BoardPlaces& printed);

}  // namespace slipstream
