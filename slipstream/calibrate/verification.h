#pragma once

#include <string>
#include <vector>

#include "slipstream/calibrate/geometry_calibration.h"

namespace slipstream {

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
Verification verify_scanner(std::vector<BoardView> views, const CalibrationBoard& board,
                            const Scanner& scanner);

}  // namespace slipstream
