#pragma once

#include <optional>

#include "slipstream/scan.h"
#include "slipstream/scan_files.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// The scanner of a scan as its file or recording has it; nullopt if it names none.
std::optional<Scanner> scanner_of(const ScanFiles& files);

/// Adds the scanner to the scan, for the region that its pictures show. Throws Error unless it
/// matches the frames.
void add_scanner(Scan& scan, std::optional<Scanner> scanner, const ScanFiles& files);

}  // namespace slipstream
