#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/io/result_files.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream::app {

/// The scans that are asked for: folders and recordings, or of recordings the windows of a range
/// "A:B", every so many. Throws Error for a range that is none or has no window.
std::vector<ScanName> scans_of(const std::vector<std::string>& paths,
                               const std::optional<std::string>& windows, std::uint64_t every,
                               const ScanChanges& changes);

}  // namespace slipstream::app
