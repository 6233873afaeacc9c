#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "slipstream/io/scan_folder.h"

namespace slipstream {

/// The CRC-32 of zlib, of bytes that come behind those of which `before` is.
std::uint32_t checksum(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);
/// The same of what a file holds. Throws Error where there is no such file.
std::uint32_t checksum_of_file(const std::filesystem::path& path, std::uint32_t before = 0);

/// One for all files that a scan consists of: scan.yaml, frames, scanner file, those of a second
/// camera; of a recording its header and the frames of the window. Throws Error where one is
/// missing.
std::uint32_t checksum_of(const ScanFiles& scan);

}  // namespace slipstream
