#pragma once

#include <filesystem>
#include <optional>

#include <CLI/App.hpp>

#include "app/board_flags.h"
#include "app/output.h"
#include "slipstream/simulate/virtual_world.h"
#include "slipstream/strategy/sequence.h"

namespace slipstream::app {

/// The flags of `simulate` that ask for a board in several poses instead of one scene.
struct SimulateBoardsFlags {
  std::optional<int> count;  ///< of poses; none: a scene is wanted
  BoardFlags board;
};

/// Adds --boards, which excludes the flags of a scene and --axis, and the flags of the board, which
/// need it. Those must have been added before.
void add_simulate_boards_flags(CLI::App& simulate, SimulateBoardsFlags& flags);

/// Takes scans of the board along x and along y in each pose, as `sequence` says, into folders
/// board01/x, board01/y and so on.
void simulate_boards(const std::filesystem::path& folder, const SimulateBoardsFlags& flags,
                     const VirtualWorld& world, const Sequence& sequence, Output& output);

}  // namespace slipstream::app
