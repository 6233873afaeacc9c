#pragma once

#include <memory>
#include <string>
#include <vector>

#include "app/commands.h"
#include "simulate/rendered_reel.h"
#include "slipstream/calibration_board.h"
#include "slipstream/image.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"

namespace slipstream::app {

struct BoardFlags {
  CalibrationBoard board;
  bool has_spacing = false;
};

/// Adds --board, --corners, --spacing, --circle-diameter, --marker-side and --dictionary.
void add_board_flags(CLI::App& subcommand, BoardFlags& flags);

/// The board described by the flags. Throws Error if it is impossible or has no spacing.
CalibrationBoard board_from(const BoardFlags& flags);

/// Parses "13x9" or "13,9": columns and rows. Throws Error naming the flag otherwise.
Size corners_from(const std::string& text, const std::string& flag);

/// Parses "121.9x80.3" or "121.9": one length or two, mm. Throws Error naming the flag otherwise.
std::vector<double> lengths_from(const std::string& text, const std::string& flag);

/// A board held in `count` poses, `still_cycles` each, under patterns along x, then along y.
/// Throws Error as board_from and poses_of.
std::shared_ptr<RenderedReel> shown_boards(const BoardFlags& board, int count, int still_cycles,
                                           const VirtualWorld& world, const Sequence& sequence);

/// The board as a flat sheet in the scene, printed finer than any camera resolves.
Body sheet_of(const CalibrationBoard& board, const Scanner& scanner);

/// `count` poses of the board. Throws Error if --boards is out of range.
std::vector<Eigen::Isometry3d> poses_of(const Body& sheet, int count, const Scanner& scanner);

}  // namespace slipstream::app
