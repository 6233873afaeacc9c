#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/page.h"
#include "slipstream/board_capture.h"
#include "slipstream/geometry_calibration.h"

namespace slipstream {

/// The same boards measured with another scanner file.
struct ScannerComparison {
  std::string name;  ///< of the file
  std::vector<std::optional<BoardQuality>> poses;
};

/// `places`: of the board's corners, mm.
ScannerComparison compared_with(const Scanner& scanner, const std::string& name,
                                const BoardViews& views, const BoardPlaces& places);

/// "chessboard of 13x9, 10 mm apart".
std::string text_of(const CalibrationBoard& board);

/// Quality of each pose, measured with a calibration of the others.
std::vector<std::optional<BoardQuality>> left_out_qualities(const GeometryCalibration& calibration);

/// Root mean square of each figure over all poses; NaN without any.
BoardQuality overall(const std::vector<std::optional<BoardQuality>>& poses);

/// Whether the calibration can be used.
Verdict verdict_of(const std::vector<Finding>& findings);

/// Contents of a report. Holds references; owns nothing.
struct CalibrationReport {
  const GeometryCalibration& calibration;
  const std::vector<UnusedPose>& unused;
  std::string board;                              ///< as text_of(board)
  const ScannerComparison* comparison = nullptr;  ///< may be null
  std::vector<Finding> findings{};                ///< of frames, ruler and calibration
  Wording wording = nullptr;                      ///< of the page
  Facts facts{};                                  ///< about the run and the scanner
};

/// A summary of a few lines: RMS, quality of the held-out poses, comparison, lens models and
/// residual maps.
std::string text_of(const CalibrationReport& report);

/// The full report with pictures: diagnostics, RMS, quality of the held-out poses, comparison,
/// parameters with standard deviations, lens models, residual maps, coverage and residuals.
Page calibration_report(const CalibrationReport& report);

}  // namespace slipstream
