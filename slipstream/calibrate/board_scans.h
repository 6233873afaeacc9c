#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "slipstream/io/scan_folder.h"

namespace slipstream {

/// The two scans of a board pose: what their pictures are and where.
struct BoardScans {
  std::string name;  ///< of the pose's folder
  ScanFiles x;
  ScanFiles y;
};

/// Says of the scan in a folder what scan.yaml does not, or otherwise. Throws Error where nothing
/// says what the pictures are.
using AmendScan = std::function<void(ScanFiles& files, const std::filesystem::path& folder)>;

/// The poses in a folder, in the order of their names with numbers counted: each a folder that
/// holds
///   - scan folders x and y, with scan.yaml or without; or
///   - the pictures of both scans, those along `first_axis` first in order of their names.
/// A folder with a report.md is none, and a folder that is itself a pose with x and y is the one.
/// Throws Error where there is none, or one is neither.
std::vector<BoardScans> board_scans(const std::filesystem::path& folder, const AmendScan& amend,
                                    Axis first_axis);

}  // namespace slipstream
