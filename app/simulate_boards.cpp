#include "app/simulate_boards.h"

#include <vector>

#include <fmt/format.h>

#include "app/progress.h"
#include "app/scan_flags.h"
#include "slipstream/base/error.h"
#include "slipstream/calibrate/calibration_board.h"
#include "slipstream/simulate/board_poses.h"
#include "slipstream/simulate/virtual_scan.h"

namespace slipstream::app {
namespace fs = std::filesystem;

Body sheet_of(const CalibrationBoard& board, const Scanner& scanner) {
  constexpr int pixels_per_spacing = 100;
  return printed_sheet(draw_board(board, pixels_per_spacing), board.spacing / pixels_per_spacing,
                       scanner);
}

std::vector<Eigen::Isometry3d> poses_of(const Body& sheet, int count, const Scanner& scanner) {
  constexpr int most_boards = 1000;
  if (count < 1 || count > most_boards) {
    throw Error(fmt::format("--boards {} is out of range; 1 to {}", count, most_boards));
  }
  const Board& shape = std::get<Board>(sheet.shape);
  return board_poses(scanner, count, shape.width, shape.height);
}

void simulate_boards(const fs::path& folder, const SimulateBoardsFlags& flags,
                     const VirtualWorld& world, const Sequence& sequence, Output& output) {
  const CalibrationBoard board = board_from(flags.board);
  const Scanner& scanner = world.scanner;
  for (const Axis axis : {Axis::x, Axis::y}) {
    require_resolved(sequence.strategy, axis, scanner.projector.size);
  }
  const Body sheet = sheet_of(board, scanner);
  const int count = flags.count.value_or(0);
  const std::vector<Eigen::Isometry3d> poses = poses_of(sheet, count, scanner);
  Progress progress("boards", count);
  const std::vector<std::string> names =
      save_board_scans(folder, sequence, world, misprinted(sheet, world.photometry.physics), poses,
                       [&] { progress.advance(); });
  progress.finish();
  output.say("took a {} of {}x{}, {:g} mm apart, in {} poses of {}; they are in {}",
             name_of(board.kind), board.columns, board.rows, board.spacing, count,
             text_of(scanner.camera.size), folder.string());
  output.document = {{"folder", folder.string()},
                     {"poses", names},
                     {"width", scanner.camera.size.width},
                     {"height", scanner.camera.size.height}};
}

void add_simulate_boards_flags(CLI::App& simulate, SimulateBoardsFlags& flags) {
  CLI::Option* boards = simulate.add_option(
      "--boards", flags.count,
      "instead of a scene: a calibration board in so many poses, scanned along x and y");
  boards->group("Board");
  for (const char* of_scene : {"--scene", "--mesh", "--mesh-size", "--reflectivity", "--move",
                               "--turn", "--vibrate", "--breathe", "--axis"}) {
    boards->excludes(simulate.get_option(of_scene));
  }
  add_board_flags(simulate, flags.board);
  for (CLI::Option* option : simulate.get_options()) {
    if (option->get_group() == "Board" && option != boards) option->needs(boards);
  }
}

}  // namespace slipstream::app
