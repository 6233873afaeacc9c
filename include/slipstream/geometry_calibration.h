#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slipstream/board_capture.h"
#include "slipstream/calibration_board.h"
#include "slipstream/check.h"
#include "slipstream/image.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// All parameters that determine the corners' pixels.
struct BundleState {
  Scanner scanner;
  std::vector<Eigen::Isometry3d> poses;  ///< board to camera frame, one for each view
  BoardPlaces places;                    ///< the board's corners in its own frame, mm
};

/// Standard deviations of a lens.
struct LensDeviation {
  Eigen::Vector2d focal = Eigen::Vector2d::Zero();            ///< pixels
  Eigen::Vector2d principal_point = Eigen::Vector2d::Zero();  ///< pixels
  std::array<double, 12> coefficients{};                      ///< 0 if fixed
};

/// Standard deviations of the result.
struct BundleDeviation {
  LensDeviation camera;
  LensDeviation projector;
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();     ///< rad, about x, y, z
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< mm
};

/// RMS distances between observed and predicted corners, pixels of the device; `stereo`: over the
/// corners of both devices.
struct ReprojectionRms {
  double camera = 0, projector = 0, stereo = 0;
};

/// A board measured with a scanner, compared with the printed one.
struct BoardQuality {
  double flatness = 0;        ///< RMS distance of the corners from their best plane, mm
  double scale_error = 0;     ///< mean over all pairs of corners of distance / printed distance - 1
  double distance_error = 0;  ///< RMS over all pairs of distance - printed distance, mm
};

/// Lens models, as numbers of distortion coefficients in OpenCV's order: no distortion, + k1, + k2,
/// + tangential, + k3, + rational, + thin prism.
inline constexpr std::array<int, 7> lens_models{0, 1, 2, 4, 5, 8, 12};

/// "none", "k1", "k1 k2", ... as reported.
const char* name_of_lens_model(int coefficients);

/// Parses a lens model: one of `lens_models`, or nullopt for "auto". Throws Error otherwise; `name`
/// is the setting's name in the message.
std::optional<int> lens_model_named(const std::string& text, const std::string& name);

/// How well a lens model predicts poses that it was not calibrated with.
struct LensModelScore {
  int coefficients = 0;
  double error = 0;  ///< RMS of the held-out poses' corners, in standard deviations
};

struct LensChoice {
  int coefficients = 0;
  std::vector<LensModelScore> scores;  ///< of the models tried; empty when chosen by flag
};

/// How well a residual map predicts poses that it was not fitted to.
struct ResidualScore {
  int degree = 0;    ///< of its polynomials; 0: no map
  double error = 0;  ///< RMS of the held-out poses' corners, in standard deviations
  double rms = 0;    ///< the same in the device's picture, pixels
};

/// The map of a device that the poses support.
struct ResidualChoice {
  int degree = 0;                     ///< 0: none
  std::vector<ResidualScore> scores;  ///< of the maps tried, first without one; empty if not asked
};

/// Deviation of a board from a flat print of the right proportions.
struct PrintShape {
  double bend = 0;            ///< height of its arch or twist, mm: quadratic in the board's places
  double bend_deviation = 0;  ///< standard deviation of `bend`, mm, from the places' roughness
  double size = 0;            ///< diagonal, mm
  double stretch = 0;         ///< scale of the columns / scale of the rows - 1
  double stretch_deviation = 0;
};

/// Offset of a board's corners in the projector's picture from the prediction by the camera's view
/// alone, projector pixels.
struct ProjectorOffset {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double spread = 0;  ///< RMS about the mean, both components together

  friend bool operator==(const ProjectorOffset&, const ProjectorOffset&) = default;
};

/// The point at which camera and projector moved relative to each other.
struct MovedRig {
  std::size_t first = 0;  ///< first pose after the move
  double gain = 1;        ///< ratio of the mean squared errors with one rig and with two
};

inline constexpr std::size_t fewest_poses = 3;

struct GeometryCalibrationSettings {
  /// Distortion coefficients, one of `lens_models`; nullopt: as many as the data support.
  std::optional<int> camera_coefficients;
  std::optional<int> projector_coefficients;
  /// Standard deviation of a printed corner, in spacings; nullopt: the print is exact.
  std::optional<double> print_deviation = 0.01;
  /// Adds to each lens a map of its model's remainder, as far as held-out poses support it.
  bool residual = false;
};

/// Fewest poses for residual maps.
inline constexpr std::size_t fewest_residual_poses = 6;

/// A pose used in the calibration.
struct CalibratedPose {
  std::string name;
  int corners = 0;  ///< found
  int lit = 0;      ///< corners with a projector pixel
  ReprojectionRms rms;
  /// Measured with a calibration of all other poses; nullopt if too few corners are lit.
  std::optional<BoardQuality> left_out{};
  ProjectorOffset offset{};  ///< under the same calibration
  /// Squared error added by this pose, divided by the others' mean without it: about 1, more if it
  /// fits badly.
  double misfit = 1;
};

struct GeometryCalibration {
  BundleState state;  ///< scanner, poses and estimated board
  BundleDeviation deviation;
  LensChoice camera_lens;
  LensChoice projector_lens;
  ResidualChoice camera_residual;
  ResidualChoice projector_residual;
  ReprojectionRms rms;
  std::vector<CalibratedPose> poses;
  BoardViews views;               ///< as used: without corners off by whole fringes
  double covered_camera = 0;      ///< share of the camera's picture covered by boards
  double covered_projector = 0;   ///< share of the projector's picture
  double largest_tilt = 0;        ///< largest angle between two boards, rad
  std::optional<MovedRig> moved;  ///< best split into two rigs
  PrintShape print;               ///< from the estimated corners of the board
  std::vector<Finding> findings;  ///< diagnostics
};

/// Calibrates camera, projector and their relative pose from board corners. The printed board
/// defines the scale. Ignores corners off by whole fringes. Throws Error for an invalid board,
/// coefficients not in `lens_models`, fewer than `fewest_poses` views, or `fewest_residual_poses`
/// for residual maps, mirrored or swapped projector axes, views that do not fit one rigid rig and
/// this board, or poses that do not determine the calibration.
GeometryCalibration calibrate_geometry(BoardViews views, const CalibrationBoard& board, Size camera,
                                       Size projector,
                                       const GeometryCalibrationSettings& settings = {});

/// The same for a flat board of any places (mm, Z nearly 0), `spacing` mm apart, for its
/// `print_deviation`. Corners may lack the pixel of either device (NaN).
GeometryCalibration calibrate_geometry(BoardViews views, const BoardPlaces& printed, double spacing,
                                       Size camera, Size projector,
                                       const GeometryCalibrationSettings& settings = {});

/// Accuracy of a scanner on a board.
struct BoardMeasure {
  /// RMS distance of the projector's pixels from the camera's epipolar lines, projector pixels.
  /// Independent of the board, but blind to movement along the lines.
  double epipolar = 0;
  ReprojectionRms rms;   ///< of the corners, with the board at its best pose
  BoardQuality quality;  ///< of the corners as points; root mean square over several boards
};

struct VerifiedPose {
  std::string name;
  BoardMeasure before;
  BoardMeasure after;  ///< with the corrected scanner
};

/// Whether a scanner is still accurate, and its correction by the boards.
struct Verification {
  std::vector<VerifiedPose> poses;
  BoardMeasure before;  ///< of all poses
  BoardMeasure after;
  Scanner corrected;       ///< with new rotation and translation, otherwise unchanged
  double rotation = 0;     ///< of the correction, rad
  double translation = 0;  ///< of the correction, mm
  bool holds = false;      ///< accurate without correction
  /// Accurate only with the correction, and that changes more than the scale: a mere change of
  /// scale would adopt a wrong board spacing.
  bool mended = false;
  std::vector<Finding> findings;
};

/// Measures boards with a calibrated scanner. Throws Error without views, for mirrored or swapped
/// axes, too few lit corners or an invalid board.
Verification verify_scanner(BoardViews views, const CalibrationBoard& board,
                            const Scanner& scanner);

}  // namespace slipstream
