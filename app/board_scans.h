#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/scan_flags.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/pattern/axis.h"

namespace slipstream::app {

/// The two scans of a board pose: what their pictures are and where.
struct BoardScans {
  std::string name;  ///< of the pose's folder
  ScanDescription x;
  ScanDescription y;
};

/// The poses in a folder, in the order of their names with numbers counted: each a folder that
/// holds
///   - scan folders x and y, with scan.yaml or flags; or
///   - the pictures of both scans, those along `first_axis` first in order of their names.
/// A folder with a report.md is none. Throws Error where there is none, or one is neither.
std::vector<BoardScans> board_scans(const std::filesystem::path& folder, const ScanFlags& flags,
                                    Axis first_axis);

}  // namespace slipstream::app
