#pragma once

#include "slipstream/base/page.h"
#include "slipstream/calibrate/board_capture.h"
#include "slipstream/calibrate/geometry_calibration.h"

namespace slipstream {

/// The same boards measured with a scanner file that came from elsewhere.
struct ScannerComparison {
  std::string name;  ///< of the file
  std::vector<std::optional<BoardQuality>> poses;
};

ScannerComparison compared_with(const Scanner& scanner, const std::string& name,
                                const BoardViews& views, const CalibrationBoard& board);

/// Of each pose, measured with a calibration of the others.
std::vector<std::optional<BoardQuality>> left_out_qualities(const GeometryCalibration& calibration);

/// One figure for all poses: the root mean square of each of the two. NaN where no pose has any.
BoardQuality overall(const std::vector<std::optional<BoardQuality>>& poses);

/// What a report is made of; refers to, does not own.
struct CalibrationReport {
  const GeometryCalibration& calibration;
  const std::vector<UnusedPose>& unused;
  const CalibrationBoard& board;
  const ScannerComparison* comparison = nullptr;  ///< may be null
  std::vector<Finding> findings{};                ///< of frames, ruler and calibration together
};

/// The result in a few lines for people: RMS, what the left-out poses say beside what another
/// scanner file says, lens models.
std::string text_of(const CalibrationReport& report);

/// All of it with pictures: findings, RMS, what the left-out poses say beside what another scanner
/// file says, parameters with their standard deviations, lens models, coverage and residuals.
Page calibration_report(const CalibrationReport& report);

}  // namespace slipstream
