#pragma once

#include <filesystem>
#include <vector>

#include "slipstream/geometry/scan.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream {

/// The poses in a folder, in natural order of their names. Each pose is a folder that contains
///   - scans x and y: folders, with or without scan.yaml, or recordings x.slip and y.slip; or
///   - the pictures of both scans, first along `first_axis`, in order of their names.
/// Skips folders with a report.html. A folder that contains x and y itself is the only pose. Throws
/// Error without poses, for a folder of neither kind, and as scan_files_in. Frames are read later,
/// as by load_frames.
std::vector<BoardScans> board_scans(const std::filesystem::path& folder, const ScanChanges& changes,
                                    Axis first_axis);

}  // namespace slipstream
