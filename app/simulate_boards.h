#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <CLI/App.hpp>
#include <Eigen/Geometry>

#include "app/board_flags.h"
#include "app/output.h"
#include "slipstream/codes/sequence.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream::app {

/// The flags of `simulate` that ask for a board in several poses instead of one scene.
struct SimulateBoardsFlags {
  std::optional<int> count;  ///< of poses; none: a scene is wanted
  BoardFlags board;
};

/// Adds --boards, which excludes the flags of a scene and --axis, and the flags of the board, which
/// need it. Those must have been added before.
void add_simulate_boards_flags(CLI::App& simulate, SimulateBoardsFlags& flags);

/// The board as a sheet in the scene, its printing as fine as a camera could ever see.
Body sheet_of(const CalibrationBoard& board, const Scanner& scanner);

/// So many poses of that sheet. Throws Error for a `count` of --boards that is out of range.
std::vector<Eigen::Isometry3d> poses_of(const Body& sheet, int count, const Scanner& scanner);

/// Takes scans of the board along x and along y in each pose, as `sequence` says, into folders
/// board01/x, board01/y and so on.
void simulate_boards(const std::filesystem::path& folder, const SimulateBoardsFlags& flags,
                     const VirtualWorld& world, const Sequence& sequence, Output& output);

}  // namespace slipstream::app
