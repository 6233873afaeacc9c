#include "app/board_flags.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "simulate/looped_scene.h"
#include "simulate/rendered_reel.h"
#include "slipstream/named_scenes.h"
#include "slipstream/virtual_world.h"

namespace slipstream::app {

void add_board_flags(CLI::App& subcommand, BoardFlags& flags) {
  const FlagGroup group{subcommand, "Board"};
  CalibrationBoard& board = flags.board;

  group.add_named("--board", board.kind, board_kind_named, name_of(board.kind),
                  "chessboard, circles (asymmetric grid), symmetric-circles or charuco");

  // Corners of the pattern, inside the board's edge.
  const auto corners = [&board](const std::string& text) {
    const auto [columns, rows] = corners_from(text, "--corners");
    board.columns = columns;
    board.rows = rows;
  };
  group.add_read<>("--corners", corners, "inner corners or circles: columns x rows")
      ->default_str("13x9");

  // Two lengths: along a row, and from row to row of a stretched print.
  const auto space = [&flags](const std::string& text) {
    const std::vector<double> spacings = lengths_from(text, "--spacing");
    flags.has_spacing = true;
    flags.board.spacing = spacings.front();
    if (spacings.size() == 2 && spacings[1] != spacings[0]) flags.board.row_spacing = spacings[1];
  };
  group.add_read<>("--spacing", space,
                   "side of a square, or distance between rows of circles, as measured on the "
                   "print, mm; 10x10.1 if the print is stretched vertically");

  // Sizes are stored as shares of the spacing, which is known: CLI11 reads flags as they are added.
  const auto circle = [&board](double mm) { board.circle_diameter = mm / board.spacing; };
  group.add_read<double>(
      "--circle-diameter", circle,
      "diameter of a circle, mm; default: 0.8 of the spacing, 0.5 in a symmetric grid");

  const auto marker = [&board](double mm) { board.marker_side = mm / board.spacing; };
  group.add_read<double>("--marker-side", marker,
                         "side of a ChArUco marker, mm; default: 0.75 of the spacing");

  const auto dictionary = [&board](const std::string& text) {
    const Size bits = size_from(text, "--dictionary");
    throw_if(bits.width != bits.height, "--dictionary {} is unknown; expected 4x4, 5x5, 6x6 or 7x7",
             text);
    board.marker_bits = bits.width;
  };
  group.add_read<>("--dictionary", dictionary, "marker dictionary: 4x4, 5x5, 6x6 or 7x7")
      ->default_str("4x4");
}

Size corners_from(const std::string& text, const std::string& flag) {
  std::string counts = text;
  std::ranges::replace(counts, ',', 'x');
  const std::optional<Size> corners = size_of_text(counts);
  throw_if(!corners, "{} '{}': expected the inner corners of a row x the rows, e.g. 13x9", flag,
           text);
  return *corners;
}

CalibrationBoard board_from(const BoardFlags& flags) {
  throw_if(!flags.has_spacing,
           "--spacing is missing: measure the side of a square on the print (for circles, the "
           "distance between rows), best over many of them, and give it in mm");
  require_valid(flags.board);
  return flags.board;
}

std::vector<double> lengths_from(const std::string& text, const std::string& flag) {
  std::vector<double> lengths = numbers_in<double>(text, 'x');
  throw_if(lengths.size() != 1 && lengths.size() != 2,
           "{} '{}': expected one length in mm, e.g. 10.2, or two, e.g. 10.2x10.1", flag, text);
  return lengths;
}

Body sheet_of(const CalibrationBoard& board, const Scanner& scanner) {
  constexpr int pixels_per_spacing = 100;
  return printed_sheet(draw_board(board, pixels_per_spacing), board.spacing / pixels_per_spacing,
                       scanner);
}

std::vector<Eigen::Isometry3d> poses_of(const Body& sheet, int count, const Scanner& scanner) {
  require_in_range(count >= 1 && count <= 1000, "--boards", count, "1 to 1000");
  const Board& shape = std::get<Board>(sheet.shape);
  return board_poses(scanner, count, shape.width, shape.height);
}

std::shared_ptr<RenderedReel> shown_boards(const BoardFlags& board, int count, int still_cycles,
                                           const VirtualWorld& world, const Sequence& sequence) {
  const Body sheet = sheet_of(board_from(board), world.scanner);
  const auto poses = poses_of(sheet, count, world.scanner);

  return std::make_shared<RenderedReel>(
      moved_board(world, misprinted(sheet, world.photometry.physics), poses,
                  along_both_axes(sequence), still_cycles),
      progress_of("rendering the boards"));
}

}  // namespace slipstream::app
