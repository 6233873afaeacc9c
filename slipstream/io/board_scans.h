#pragma once

#include <filesystem>
#include <vector>

#include "slipstream/geometry/scan.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream {

/// The poses in a folder, in the order of their names with numbers counted: each a folder that
/// holds
///   - scans x and y: folders, with scan.yaml or without, or recordings x.slip and y.slip; or
///   - the pictures of both scans, those along `first_axis` first in order of their names.
/// A folder with a report.md is none, and a folder that is itself a pose with x and y is the one.
/// Throws Error where there is none, one is neither, or as scan_files_in; frames are read, and
/// throw, as load_frames.
std::vector<BoardScans> board_scans(const std::filesystem::path& folder, const ScanChanges& changes,
                                    Axis first_axis);

}  // namespace slipstream
