#pragma once

#include <optional>
#include <string>
#include <vector>

#include "slipstream/calibrate/board_quality.h"
#include "slipstream/calibrate/board_view.h"
#include "slipstream/calibrate/bundle_adjustment.h"
#include "slipstream/calibrate/calibration_board.h"
#include "slipstream/calibrate/lens_choice.h"
#include "slipstream/calibrate/one_rig.h"
#include "slipstream/calibrate/print_shape.h"
#include "slipstream/calibrate/projector_offset.h"
#include "slipstream/calibrate/reprojection.h"
#include "slipstream/check/finding.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

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
  std::optional<BoardQuality> left_out;
  ProjectorOffset offset;  ///< under that calibration
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
  std::vector<BoardView> views;   ///< as they took part: without corners off by fringes
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
GeometryCalibration calibrate_geometry(std::vector<BoardView> views, const CalibrationBoard& board,
                                       Size camera, Size projector,
                                       const GeometryCalibrationSettings& settings = {});

}  // namespace slipstream
