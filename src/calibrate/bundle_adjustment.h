#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "calibrate/board_view.h"
#include "calibrate/reprojection.h"
#include "slipstream/geometry_calibration.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// The parameters that a bundle adjustment may change.
struct BundleSettings {
  /// Number of free distortion coefficients, in OpenCV's order: 0, 1, 2, 4, 5, 8 or 12. The others
  /// are fixed.
  int camera_coefficients = 5;
  int projector_coefficients = 5;
  bool hold_camera = false;     ///< fixes its lens
  bool hold_projector = false;  ///< fixes its lens
  /// Standard deviation of a corner's printing error, mm; nullopt fixes the places.
  std::optional<double> print_deviation = std::nullopt;
  bool hold_rig = false;  ///< fixes rotation and translation
  /// nullopt: estimated robustly, in three rounds of adjustment.
  std::optional<PixelDeviations> pixel_deviations = std::nullopt;
};

/// Only the boards move.
inline constexpr BundleSettings all_held{
    .hold_camera = true, .hold_projector = true, .hold_rig = true};

/// Sets the fixed distortion coefficients to zero, so that none remain from a larger lens model.
void forget_held_coefficients(Scanner& scanner, const BundleSettings& settings);

/// Minimises the reprojection errors of both devices over all free parameters, with Huber's loss
/// and each device's errors in units of their robustly estimated standard deviation. Starts from
/// `state`, whose poses and places must match `views`; `printed`: nominal corners of the board.
/// Keeps the lenses' residual maps. If not null, `deviation` receives the standard deviations for
/// independent corner errors. Throws Error if it does not converge, or if the poses do not
/// determine the requested `deviation`.
BundleState bundle_adjusted(const BoardViews& views, BundleState state, const BoardPlaces& printed,
                            const BundleSettings& settings, BundleDeviation* deviation = nullptr);

/// The larger of `deviation`, which assumes independent corner errors, and the jackknife's of
/// calibrations without each pose. The jackknife includes errors common to a pose's corners, but
/// not errors common to all poses, such as the print's scale.
BundleDeviation widened(BundleDeviation deviation, const std::vector<Scanner>& without_one);

}  // namespace slipstream
