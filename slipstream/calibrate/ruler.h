#pragma once

#include <vector>

#include "slipstream/calibrate/calibration_board.h"
#include "slipstream/check/finding.h"

namespace slipstream {

/// What a ruler says of a print, mm: from the first to the last corner of a row and of a column.
struct MeasuredPrint {
  double along_row = 0;
  double along_column = 0;
};

/// Whether the print is as large as the board says and stretched along neither axis, as well as a
/// ruler can tell: nothing else can, since a calibration of any scale fits the frames as well. The
/// advice holds the spacing to give. Throws Error for lengths that are not above 0.
std::vector<Finding> findings_of_ruler(const CalibrationBoard& board,
                                       const MeasuredPrint& measured);

}  // namespace slipstream
