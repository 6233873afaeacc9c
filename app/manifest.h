#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "slipstream/io/result_files.h"

namespace slipstream::app {

/// What became of scans, each a line of JSON, as docs/reference/files.md says; the last of a scan holds.
struct Manifest {
  std::map<ScanName, nlohmann::json> entries{};
  std::uint64_t lines = 0;        ///< that could be read
  std::uint64_t whole_bytes = 0;  ///< up to the end of the last line that has one
};

/// Lines that cannot be read are left out, as a crash leaves one at the end. Throws Error, calling
/// the file `name`, where it does not begin as a manifest does.
Manifest manifest_from(std::string_view text, const std::string& name);
/// The same of a file; of one that is missing an empty one.
Manifest read_manifest(const std::filesystem::path& path);

/// The beginning of a scan's entry: `scan`, `window`, `settings`, `version`.
nlohmann::json entry_for(const ScanName& scan, const std::vector<std::string>& settings);

/// Its line; bytes that are no UTF-8 are replaced.
std::string line_of(const nlohmann::json& entry);

/// `outputs` of an entry: path, bytes and checksum of each file; null of one that is not there.
nlohmann::json sums_of(const std::vector<std::string>& paths);

/// Why what is asked for is not done and whole with those outputs; empty where it is.
std::string why_not_done(const Manifest& manifest, const ScanName& scan,
                         const nlohmann::json& asked, const std::vector<std::string>& outputs);

}  // namespace slipstream::app
