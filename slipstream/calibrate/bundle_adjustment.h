#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slipstream/calibrate/board_view.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// Everything that the pictures of the corners depend on.
struct BundleState {
  Scanner scanner;
  std::vector<Eigen::Isometry3d> poses;  ///< board's frame to the camera's, one for each view
  std::vector<Eigen::Vector3d> places;   ///< the board's corners in its own frame, mm
};

/// Standard deviations of the components of the distances between corners as seen and as predicted,
/// pixels; the projector's without what comes of the camera's (BoardView::slopes).
struct PixelDeviations {
  double camera = 1;
  double projector = 1;
};

/// What a bundle adjustment may change.
struct BundleSettings {
  /// How many of the distortion coefficients, in OpenCV's order, are free: 0, 1, 2, 4, 5, 8 or 12.
  /// The others stay as they are.
  int camera_coefficients = 5;
  int projector_coefficients = 5;
  bool hold_camera = false;     ///< its lens stays as it is
  bool hold_projector = false;  ///< its lens stays as it is
  /// Standard deviation of a corner from where it should be printed, mm; none: places are held.
  std::optional<double> print_deviation = std::nullopt;
  bool hold_rig = false;  ///< projector and camera stay as they stand
  /// Where known; none: estimated, robustly, three times while everything moves.
  std::optional<PixelDeviations> pixel_deviations = std::nullopt;
};

/// Sets the distortion coefficients that are not free under these settings to zero: what was fitted
/// with more of them must not stay.
void forget_held_coefficients(Scanner& scanner, const BundleSettings& settings);

/// Standard deviations of a lens.
struct LensDeviation {
  Eigen::Vector2d focal = Eigen::Vector2d::Zero();            ///< pixels
  Eigen::Vector2d principal_point = Eigen::Vector2d::Zero();  ///< pixels
  std::array<double, 12> coefficients{};                      ///< 0 for those that were held
};

/// How far the result may be off: standard deviations.
struct BundleDeviation {
  LensDeviation camera;
  LensDeviation projector;
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();     ///< rad, about x, y, z
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< mm
};

/// Moves everything together to where the distances, in both devices, between corners as seen and
/// as they ought to be seen are least: Huber's robust loss, each device's distances in units of
/// their robustly estimated standard deviation. Starts from `start`, whose poses and places must be
/// those of `views`; `printed` is where the board's corners should be. `deviation`, where not null,
/// receives the standard deviations for corners that err independently. Throws Error when it does
/// not converge to finite numbers, or `deviation` is asked for and the poses do not determine it.
BundleState bundle_adjusted(const std::vector<BoardView>& views, BundleState start,
                            const std::vector<Eigen::Vector3d>& printed,
                            const BundleSettings& settings, BundleDeviation* deviation = nullptr);

/// The larger of `deviation`, for which all corners err independently, and of the jackknife: m
/// calibrations, each without one of the m poses, deviate from their mean by
/// sigma^2 = (m - 1) / m * (sum of squares). That also counts what the corners of a pose err by in
/// common, but not what all poses do, such as the print's scale.
BundleDeviation widened(const BundleDeviation& deviation, const std::vector<Scanner>& without_one);

PixelDeviations pixel_deviations(const std::vector<BoardView>& views, const BundleState& state);

/// Mean over the corners of all views of the squared distances in both devices, in squares of the
/// standard deviations, as bundle_adjusted sees them: 4 where these are right.
double mean_squared_error(const std::vector<BoardView>& views, const BundleState& state,
                          const PixelDeviations& deviations);

/// Seen minus predicted, pixels, for each corner of a view; NaN where it was not seen.
std::vector<Eigen::Vector2d> camera_residuals(const BoardView& view, const Scanner& scanner,
                                              const Eigen::Isometry3d& pose,
                                              const std::vector<Eigen::Vector3d>& places);
std::vector<Eigen::Vector2d> projector_residuals(const BoardView& view, const Scanner& scanner,
                                                 const Eigen::Isometry3d& pose,
                                                 const std::vector<Eigen::Vector3d>& places);

}  // namespace slipstream
