#include "app/simulate_boards.h"

#include <vector>

#include <fmt/format.h>

#include "app/progress.h"
#include "app/scan_flags.h"
#include "slipstream/calibrate/calibration_board.h"
#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/simulate/board_poses.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

/// The board as a sheet in the scene, its printing as fine as a camera could ever see.
Body sheet_of(const CalibrationBoard& board, const Scanner& scanner) {
  constexpr int pixels_per_spacing = 100;
  return printed_sheet(draw_board(board, pixels_per_spacing), board.spacing / pixels_per_spacing,
                       scanner);
}

void take_and_write(const fs::path& folder, const Scanner& scanner, const Scene& scene,
                    ScanDescription scan, const Photometry& photometry) {
  const FrameSet frames =
      take_scan(scanner, scene, pattern_set(scan.strategy, scan.axis, scan.light), photometry)
          .frames;
  make_folder(folder);
  scan.frames = frame_names(folder, frames);
  if (frames.quantised()) scan.bits = frames.bits();
  write_frames(scan.frames, frames);
  write_scan_description(folder / "scan.yaml", scan);
}

}  // namespace

std::vector<fs::path> frame_names(const fs::path& folder, const FrameSet& frames) {
  std::vector<fs::path> names;
  for (int n = 0; n < frames.count(); ++n) {
    names.push_back(folder / fmt::format("frame_{:02}.{}", n, frames.quantised() ? "png" : "tiff"));
  }
  return names;
}

void simulate_boards(const fs::path& folder, const SimulateBoardsFlags& flags,
                     const Scanner& scanner, const ScanDescription& scan,
                     const Photometry& photometry, Output& output) {
  constexpr int most_boards = 1000;
  const int count = flags.count.value_or(0);
  if (count < 1 || count > most_boards) {
    throw Error(fmt::format("--boards {} is out of range; 1 to {}", count, most_boards));
  }
  const CalibrationBoard board = board_from(flags.board);
  require_resolved(scan.strategy, length_along(Axis::y, scanner.projector.size));
  Body sheet = sheet_of(board, scanner);
  const Board& shape = std::get<Board>(sheet.shape);
  const std::vector<Eigen::Isometry3d> poses =
      board_poses(scanner, count, shape.width, shape.height);

  make_folder(folder);
  write_scanner(folder / "scanner.yaml", scanner);
  Progress progress("boards", count);
  nlohmann::json names = nlohmann::json::array();
  for (int i = 0; i < count; ++i) {
    sheet.pose = poses[static_cast<std::size_t>(i)];
    const std::string name = fmt::format("board{:02}", i + 1);
    for (const Axis axis : {Axis::x, Axis::y}) {
      ScanDescription of_axis = scan;
      of_axis.axis = axis;
      of_axis.scanner = folder / "scanner.yaml";
      Photometry of_scan = photometry;
      of_scan.seed =
          photometry.seed + 2 * static_cast<std::uint64_t>(i) + (axis == Axis::x ? 0 : 1);
      take_and_write(folder / name / name_of(axis), scanner, {sheet}, of_axis, of_scan);
    }
    names.push_back(name);
    progress.advance();
  }
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
  for (const char* of_scene :
       {"--scene", "--mesh", "--mesh-size", "--reflectivity", "--motion", "--axis"}) {
    boards->excludes(simulate.get_option(of_scene));
  }
  add_board_flags(simulate, flags.board);
  for (CLI::Option* option : simulate.get_options()) {
    if (option->get_group() == "Board" && option != boards) option->needs(boards);
  }
}

}  // namespace slipstream::app
