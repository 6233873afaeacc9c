#pragma once

#include <array>
#include <cmath>
#include <functional>

#include <Eigen/Geometry>

#include "slipstream/calibrate/board_view.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// Everything that the pictures of the corners depend on.
struct BundleState {
  Scanner scanner;
  std::vector<Eigen::Isometry3d> poses;  ///< board's frame to the camera's, one for each view
  BoardPlaces places;                    ///< the board's corners in its own frame, mm
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
BundleState bundle_adjusted(const BoardViews& views, BundleState start, const BoardPlaces& printed,
                            const BundleSettings& settings, BundleDeviation* deviation = nullptr);

/// The larger of `deviation`, for which all corners err independently, and of the jackknife: m
/// calibrations, each without one of the m poses, deviate from their mean by
/// sigma^2 = (m - 1) / m * (sum of squares). That also counts what the corners of a pose err by in
/// common, but not what all poses do, such as the print's scale.
BundleDeviation widened(const BundleDeviation& deviation, const std::vector<Scanner>& without_one);

PixelDeviations pixel_deviations(const BoardViews& views, const BundleState& state);

/// Mean over the corners of all views of the squared distances in both devices, in squares of the
/// standard deviations, as bundle_adjusted sees them: 4 where these are right.
double mean_squared_error(const BoardViews& views, const BundleState& state,
                          const PixelDeviations& deviations);

/// Some of the poses, and the state of those.
struct SomePoses {
  BoardViews views;
  BundleState state;
};
/// Those of whose index `takes` says so.
SomePoses some_poses(const BoardViews& views, const BundleState& state,
                     const std::function<bool(std::size_t pose)>& takes);

/// Seen minus predicted, pixels, for each corner of a view that is pose `v` of the state; NaN where
/// the device does not see it.
PixelPlaces residuals(const BoardView& view, const BundleState& state, std::size_t v,
                      Device device);

/// Sum of squares, and of how many.
struct Squares {
  double sum = 0;
  int count = 0;

  void add(double square) {
    sum += square;
    ++count;
  }
  void add(const Squares& other) {
    sum += other.sum;
    count += other.count;
  }
  /// 0 of none.
  [[nodiscard]] double rms() const { return count > 0 ? std::sqrt(sum / count) : 0; }
};

/// RMS distances between corners as seen and as predicted, pixels of the device; `stereo` over the
/// corners of both devices together.
struct ReprojectionRms {
  double camera = 0;
  double projector = 0;
  double stereo = 0;
};

/// The same distances, squared.
struct Reprojection {
  Squares camera, projector;

  void add(const Reprojection& other) {
    camera.add(other.camera);
    projector.add(other.projector);
  }
  [[nodiscard]] ReprojectionRms rms() const;
};

/// Of a view that is pose `v` of the state.
Reprojection reprojection(const BoardView& view, const BundleState& state, std::size_t v);

/// A board measured with a scanner, corner by corner, against what a board is.
struct BoardQuality {
  double flatness = 0;        ///< RMS distance of the corners from their best plane, mm
  double scale_error = 0;     ///< mean over all pairs of corners of distance / printed distance - 1
  double distance_error = 0;  ///< RMS over all pairs of distance - printed distance, mm
};

/// Nothing where less than four corners are lit.
std::optional<BoardQuality> board_quality(const BoardView& view, const Scanner& scanner,
                                          const BoardPlaces& printed);

}  // namespace slipstream
