#include "app/board_flags.h"

#include <fmt/format.h>

#include "app/flag_group.h"
#include "app/scan_flags.h"
#include "slipstream/base/error.h"
#include "slipstream/base/number_text.h"

namespace slipstream::app {

void add_board_flags(CLI::App& subcommand, BoardFlags& flags) {
  const FlagGroup group{subcommand, "Board"};
  group.add("--board", flags.kind, "chessboard, circles (asymmetric grid) or charuco");
  group.add("--corners", flags.corners, "corners between squares, or circles: in a row x rows");
  group.add("--spacing", flags.spacing,
            "mm, as measured on the print: side of a square; for circles from one row to the next; "
            "10x10.1 of a print stretched down");
  group.add("--circle-diameter", flags.circle_diameter, "mm; 0.8 of the spacing where not given");
  group.add("--marker-side", flags.marker_side,
            "mm, of a ChArUco marker; 0.75 of the spacing where not given");
  group.add("--dictionary", flags.dictionary, "of the markers: 4x4, 5x5, 6x6 or 7x7");
}

CalibrationBoard board_from(const BoardFlags& flags) {
  const Size corners = size_from(flags.corners, "--corners");
  const Size dictionary = size_from(flags.dictionary, "--dictionary");
  if (dictionary.width != dictionary.height) {
    throw Error(
        fmt::format("--dictionary {} is not known; it is 4x4, 5x5, 6x6 or 7x7", flags.dictionary));
  }
  if (!flags.spacing) {
    throw Error(
        "--spacing is missing: measure the side of a square on the print, best across many of "
        "them, "
        "and give it in mm (for circles, from one row to the next)");
  }
  const std::vector<double> spacings = lengths_from(*flags.spacing, "--spacing");
  CalibrationBoard board{.kind = board_kind_named(flags.kind),
                         .columns = corners.width,
                         .rows = corners.height,
                         .spacing = spacings.front(),
                         .marker_bits = dictionary.width};
  if (spacings.size() == 2 && spacings[1] != spacings[0]) board.row_spacing = spacings[1];
  if (flags.circle_diameter) board.circle_diameter = *flags.circle_diameter / board.spacing;
  if (flags.marker_side) board.marker_side = *flags.marker_side / board.spacing;
  require_valid(board);
  return board;
}

std::vector<double> lengths_from(const std::string& text, const std::string& flag) {
  std::vector<double> lengths = numbers_in<double>(text, 'x');
  if (lengths.size() == 1 || lengths.size() == 2) return lengths;
  throw Error(
      fmt::format("{} '{}' is not a length; give mm, as 10.2, or two, as 10.2x10.1", flag, text));
}

}  // namespace slipstream::app
