#pragma once

#include <string>
#include <vector>

#include "app/output.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream::app {

bool is_mcap(const std::string& path);

/// Throws Error, which says how files get names of their own.
[[noreturn]] void refuse_second(const std::string& path);

/// The frames of recordings, scan folders and MCAP files that live scans have written, one behind
/// another in one recording. Throws Error where they are not all of one camera and sequence.
void convert_to_recording(const std::vector<std::string>& paths, const std::string& recording,
                          Output& output);

/// Each whole cycle of recordings as a scan folder. In its name "{name}" stands for the recording's
/// and "{window}" for the cycle's number; `changes` are of what the recording says.
void convert_to_folders(const std::vector<std::string>& recordings, const std::string& folder,
                        const ScanChanges& changes, Output& output);

}  // namespace slipstream::app
