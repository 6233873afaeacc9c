#pragma once

#include "slipstream/calibrate/bundle_adjustment.h"

namespace slipstream {

/// Numbers of distortion coefficients, in OpenCV's order, that make a lens model: none, k1, and k2,
/// and tangential, and k3, rational, and thin prism.
inline constexpr std::array<int, 7> lens_models{0, 1, 2, 4, 5, 8, 12};

/// "none", "k1", "k1 k2", ... as reported.
const char* name_of_lens_model(int coefficients);

/// The coefficients of a lens model by a text: one of `lens_models`, or none for "auto". Throws
/// Error, by `name` what a message calls the text, for another.
std::optional<int> lens_model_named(const std::string& text, const std::string& name);

/// How well a lens model foresees poses that it was not calibrated with.
struct LensModelScore {
  int coefficients = 0;
  double error = 0;  ///< RMS of the left-out poses' corners, in standard deviations
};

struct LensChoice {
  int coefficients = 0;
  std::vector<LensModelScore> scores;  ///< of the models that were tried; empty where by flag
};

/// How a board differs from a flat print of the right proportions.
struct PrintShape {
  double bend = 0;            ///< height of its arch or twist, mm: quadratic in the board's places
  double bend_deviation = 0;  ///< standard deviation of that, mm, by how rough the places are
  double size = 0;            ///< diagonal, mm
  double stretch = 0;         ///< how much longer, for its length, it is down than across, - 1
  double stretch_deviation = 0;
};

/// Where the projector sees a board's corners, against where it should if the board stands where
/// the camera alone sees it: projector pixels.
struct ProjectorOffset {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double spread = 0;  ///< RMS about the mean, of both components together

  friend bool operator==(const ProjectorOffset&, const ProjectorOffset&) = default;
};

/// Where camera and projector were moved against each other.
struct MovedRig {
  std::size_t first = 0;  ///< pose of the rig as it then stood
  double gain = 1;        ///< mean squared error with one rig, over that with two
};

inline constexpr std::size_t fewest_poses = 3;

struct GeometryCalibrationSettings {
  /// Distortion coefficients, one of `lens_models`; none: as many as the data support.
  std::optional<int> camera_coefficients;
  std::optional<int> projector_coefficients;
  /// How far a printed corner may be from its place, in spacings: a standard deviation. None: the
  /// print is taken for exact.
  std::optional<double> print_deviation = 0.01;
};

/// A pose that took part.
struct CalibratedPose {
  std::string name;
  int corners = 0;  ///< seen
  int lit = 0;      ///< of them, with a projector pixel
  ReprojectionRms rms;
  /// Measured with a calibration of all the other poses. None where too few corners are lit.
  std::optional<BoardQuality> left_out{};
  ProjectorOffset offset{};  ///< under that calibration
  /// The squared error that it brings in, over what each of the others has without it: about 1,
  /// and the more the worse it fits.
  double misfit = 1;
};

struct GeometryCalibration {
  BundleState state;  ///< the scanner, the poses and the board as it was found to be
  BundleDeviation deviation;
  LensChoice camera_lens;
  LensChoice projector_lens;
  ReprojectionRms rms;
  std::vector<CalibratedPose> poses;
  BoardViews views;               ///< as they took part: without corners off by fringes
  double covered_camera = 0;      ///< share of the camera's picture that some board covered
  double covered_projector = 0;   ///< share of the projector's picture
  double largest_tilt = 0;        ///< largest angle between two boards, rad
  std::optional<MovedRig> moved;  ///< where, if anywhere, the rig moved between poses
  PrintShape print;               ///< of the board, as its corners were found to be
  std::vector<Finding> findings;  ///< what speaks against it, and why that may be
};

/// Camera, projector and how they stand to each other, from where both see a board's corners. The
/// printed board gives the scale. Corners off by fringes take no part. Throws Error for a board
/// that cannot be, coefficients that are none of `lens_models`, fewer than `fewest_poses` views,
/// views of mirrored or swapped projector axes, views that cannot be of one rigid rig and that
/// board, or poses that do not determine the calibration.
GeometryCalibration calibrate_geometry(BoardViews views, const CalibrationBoard& board, Size camera,
                                       Size projector,
                                       const GeometryCalibrationSettings& settings = {});

/// How a scanner measures a board.
struct BoardMeasure {
  /// RMS distance of the projector's pixels from the epipolar lines of the camera's: px of the
  /// projector. It needs no board; only what moved along the lines it does not see.
  double epipolar = 0;
  ReprojectionRms rms;   ///< of the corners, the board standing where it fits best
  BoardQuality quality;  ///< of the corners as points; over several boards the root mean square
};

struct VerifiedPose {
  std::string name;
  BoardMeasure before;
  BoardMeasure after;  ///< with the corrected scanner
};

/// Whether a scanner still holds, and what it is like with camera and projector moved to where the
/// boards say that they stand.
struct Verification {
  std::vector<VerifiedPose> poses;
  BoardMeasure before;  ///< of all poses
  BoardMeasure after;
  Scanner corrected;       ///< other rotation and translation, all else as it was
  double rotation = 0;     ///< by which it differs, rad
  double translation = 0;  ///< mm
  bool holds = false;      ///< as it is
  /// It does not hold as it is, but corrected it does, and not by its scale alone: that would take
  /// over a wrong spacing.
  bool mended = false;
  std::vector<Finding> findings;
};

/// Measures boards with a scanner that was calibrated before. Throws Error where there is no view,
/// one of them has mirrored or swapped axes or too few lit corners, or the board cannot be.
Verification verify_scanner(BoardViews views, const CalibrationBoard& board,
                            const Scanner& scanner);

}  // namespace slipstream
