#include "app/board_flags.h"

#include <fmt/format.h>

#include "app/flag_group.h"
#include "app/scan_flags.h"
#include "slipstream/error/error.h"

namespace slipstream::app {

void add_board_flags(CLI::App& subcommand, BoardFlags& flags) {
  const FlagGroup group{subcommand, "Board"};
  group.add("--board", flags.kind, "chessboard, circles (asymmetric grid) or charuco");
  group.add("--corners", flags.corners, "corners between squares, or circles: in a row x rows");
  group.add("--spacing", flags.spacing,
            "mm: side of a square; for circles from one row to the next");
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
  CalibrationBoard board{.kind = board_kind_named(flags.kind),
                         .columns = corners.width,
                         .rows = corners.height,
                         .spacing = flags.spacing,
                         .marker_bits = dictionary.width};
  if (flags.circle_diameter) board.circle_diameter = *flags.circle_diameter / board.spacing;
  if (flags.marker_side) board.marker_side = *flags.marker_side / board.spacing;
  require_valid(board);
  return board;
}

}  // namespace slipstream::app
