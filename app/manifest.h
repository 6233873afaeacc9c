#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "io/result_files.h"

namespace slipstream::app {

/// Results of scans, one JSON line each, see docs/reference/files.md; the last line of a scan
/// counts.
struct Manifest {
  std::map<ScanName, nlohmann::json> entries{};
  std::uint64_t lines = 0;        ///< lines that could be read
  std::uint64_t whole_bytes = 0;  ///< up to the end of the last complete line
};

/// Skips unreadable lines, as a crash leaves one at the end. Throws Error, naming the file `name`,
/// if it does not start like a manifest.
Manifest manifest_from(std::string_view text, const std::string& name);

/// Reads a file; a missing file gives an empty manifest.
Manifest read_manifest(const std::filesystem::path& path);

/// The start of a scan's entry: `scan`, `window`, `settings`, `version`.
nlohmann::json entry_for(const ScanName& scan, const std::vector<std::string>& settings);

/// The entry's line; invalid UTF-8 is replaced.
std::string line_of(const nlohmann::json& entry);

/// `outputs` of an entry: path, size in bytes and checksum of each file; null for a missing file.
nlohmann::json sums_of(const std::vector<std::string>& paths);

/// Why the scan must be done again with these outputs; empty if it is complete.
std::string why_not_done(const Manifest& manifest, const ScanName& scan,
                         const nlohmann::json& expected, const std::vector<std::string>& outputs);

}  // namespace slipstream::app
