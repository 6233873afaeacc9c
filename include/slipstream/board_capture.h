#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slipstream/calibration_board.h"
#include "slipstream/check.h"
#include "slipstream/image.h"
#include "slipstream/response.h"
#include "slipstream/scan.h"

namespace slipstream {

/// Quality of one scan of a board, from a few thousand bright, unsaturated pixels.
struct FringeSigns {
  double saturated = 0;  ///< share of the board's pixels with a saturated frame
  int steps = 0;         ///< N of the measuring band; 0 if it is not a run of steps
  double period = 0;     ///< of the measuring band's fringe, projector pixels; 0 if not measured
  /// Amplitude and standard deviation, rad, of the phase error that repeats N times per fringe,
  /// relative to the smooth phase of a flat board.
  double ripple = 0;
  double ripple_deviation = 0;
  /// Ratio of the finest to the coarsest band's modulation, each divided by its share: 1 for sharp
  /// fringes, less if blurred.
  double contrast = 1;
};

/// Blur of the board's printed edges in a picture: standard deviation of the equivalent Gaussian,
/// median over all edges, in pixels and in spacings of the board.
struct EdgeSoftness {
  double pixels = 0;
  double spacings = 0;
};

/// Quality of one pose's frames.
struct CaptureSigns {
  FringeSigns x{};
  FringeSigns y{};
  EdgeSoftness edges{};
};

/// One pose of the board: its corners in the camera's and the projector's picture.
struct BoardView {
  std::string name;         ///< of the pose's folder
  std::vector<int> places;  ///< board place of each corner
  PixelPlaces camera;       ///< pixels
  PixelPlaces projector;    ///< pixels; NaN where unknown
  /// d projector / d camera: an error of a corner's camera pixel causes this error of its projector
  /// pixel. Empty or zero if the projector pixels are independent of the camera's.
  std::vector<Eigen::Matrix2d> slopes{};
  CaptureSigns signs{};  ///< quality of its frames; default if it has none
};

using BoardViews = std::vector<BoardView>;

struct BoardCaptureSettings {
  /// Grey levels of 8 bits, 0 to 255; darker pixels are ignored.
  double minimum_modulation = 5;
  double neighbourhood = 0.7;  ///< radius as a share of the distance to the next corner, to 10
  std::optional<MeasuredResponse> response{};  ///< corrects the phases
  Size projector{};                            ///< of scans that do not give it
};

/// Result of one pose.
struct BoardCapture {
  std::optional<BoardView> view;    ///< nullopt if the pose cannot be used
  std::string message;              ///< which detector found the board, or why none did
  std::vector<Finding> findings{};  ///< of the frames; `wrong` rejects the pose
};

/// Finds the board in a pose's frames and, from a scan along each axis, the projector pixel of each
/// corner. Puts slipped frames in order first. Throws Error if the scans do not match their
/// strategy, differ in picture or projector size, give no coordinate or only with the ambient
/// light, if the board is larger than `board`, or if a setting is out of range.
BoardCapture board_capture(const std::string& name, const CalibrationBoard& board, Scan along_x,
                           Scan along_y, const BoardCaptureSettings& settings = {});

/// A pose that was not used.
struct UnusedPose {
  std::string name;
  std::string why;
};

/// Result of all poses of a board.
struct PoseCaptures {
  BoardViews views{};
  std::vector<UnusedPose> unused{};
  Size camera{};
  Size projector{};
  std::vector<std::string> warnings{};  ///< from reading the frames
  std::vector<Finding> findings{};      ///< of the poses' frames
};

/// Finds the board in all poses except `excluded` (by name). Calls `report` after each pose with a
/// description (empty when excluded). Throws Error with the pose's name if its frames cannot be
/// read or used, or come from another camera or projector than earlier poses, and for an excluded
/// name that is not in the folder.
PoseCaptures capture_poses(const std::string& folder, const std::vector<BoardScans>& poses,
                           const std::vector<std::string>& excluded, const CalibrationBoard& board,
                           const BoardCaptureSettings& settings,
                           const std::function<void(const std::string& words)>& report);

/// Throws Error with the folder's name if too few poses are usable.
void require_enough_poses(const PoseCaptures& captures, const std::string& folder);

}  // namespace slipstream
