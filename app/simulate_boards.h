#pragma once

#include <filesystem>
#include <optional>

#include <CLI/App.hpp>

#include "app/board_flags.h"
#include "app/output.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream::app {

/// The flags of `simulate` that ask for a board in several poses instead of one scene.
struct SimulateBoardsFlags {
  std::optional<int> count;  ///< of poses; none: a scene is wanted
  BoardFlags board;
};

/// Adds --boards, which excludes the flags of a scene and --axis, and the flags of the board, which
/// need it. Those must have been added before.
void add_simulate_boards_flags(CLI::App& simulate, SimulateBoardsFlags& flags);

/// Takes scans of the board along x and along y in each pose, as `scan` says, into folders
/// board01/x, board01/y and so on.
void simulate_boards(const std::filesystem::path& folder, const SimulateBoardsFlags& flags,
                     const Scanner& scanner, const ScanDescription& scan,
                     const Photometry& photometry, Output& output);

/// Where the frames of a scan go: frame_00.png, ...; .tiff where they are not quantised.
std::vector<std::filesystem::path> frame_names(const std::filesystem::path& folder,
                                               const FrameSet& frames);

}  // namespace slipstream::app
