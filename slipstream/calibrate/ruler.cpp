#include "slipstream/calibrate/ruler.h"

#include <Eigen/Core>
#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

/// What a length read off a ruler may be off, mm: a quarter of a division at either end.
constexpr double ruler_error = 0.3;

/// From the first to the last corner of a row and of a column, mm, as said.
Eigen::Array2d said_lengths(const CalibrationBoard& board) {
  const Eigen::Vector3d last = printed_places(board).back();
  const double shifted = board.kind == BoardKind::circles && board.rows % 2 == 0 ? 1 : 0;
  return {last.x() - shifted * board.spacing, last.y()};
}

}  // namespace

std::vector<Finding> findings_of_ruler(const CalibrationBoard& board,
                                       const MeasuredPrint& measured) {
  const Eigen::Array2d is(measured.along_row, measured.along_column);
  if (!((is > 0).all() && is.isFinite().all())) {
    throw Error(fmt::format("measured {:g}x{:g} mm is out of range; both lengths are above 0",
                            measured.along_row, measured.along_column));
  }
  const Eigen::Array2d said = said_lengths(board), scale = is / said;
  if (((is - said).abs() <= ruler_error).all()) return {};
  const double row_spacing = board.row_spacing.value_or(board.spacing);
  Finding finding{.what = "the print is not as large as said",
                  .evidence = {{"rows, % too long", 100 * (scale[0] - 1)},
                               {"columns, % too long", 100 * (scale[1] - 1)}},
                  .likely = "a print of the wrong scale, such as by 'fit to page'",
                  .advice = ""};
  // One scale fits both lengths to what the ruler may be off.
  const double common = is.sum() / said.sum();
  const bool stretched = ((is - common * said).abs() > ruler_error).any();
  if (((is.reverse() - said).abs() <= ruler_error).all()) {
    finding.likely = "the lengths of row and column were exchanged";
    finding.advice = fmt::format("give --measured {:g}x{:g}", is[1], is[0]);
  } else if (stretched) {
    finding.likely = "a print stretched along one axis, or of the wrong scale along each";
    finding.advice = fmt::format("give --spacing {:.4g}x{:.4g}", scale[0] * board.spacing,
                                 scale[1] * row_spacing);
  } else if (board.row_spacing) {
    finding.advice =
        fmt::format("give --spacing {:.4g}x{:.4g}", common * board.spacing, common * row_spacing);
  } else {
    finding.advice = fmt::format("give --spacing {:.4g}", common * board.spacing);
  }
  return {finding};
}

}  // namespace slipstream
