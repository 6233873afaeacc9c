#include "app/manifest.h"

#include <optional>

#include "base/throw_if-inl.h"
#include "io/file.h"

namespace slipstream::app {
namespace fs = std::filesystem;

Manifest manifest_from(std::string_view text, const std::string& name) {
  const std::string_view begin = "{\"";

  // The first bytes tell a manifest from any other file, even if only one byte was written yet.
  throw_if(text.substr(0, begin.size()) != begin.substr(0, text.size()),
           "{}: not a manifest of slipstream", name);

  // Only lines with a line break are complete. The last line of a scan counts.
  Manifest manifest;
  for (std::size_t end = 0; (end = text.find('\n', manifest.whole_bytes)) != text.npos;) {
    nlohmann::json entry = nlohmann::json::parse(
        text.substr(manifest.whole_bytes, end - manifest.whole_bytes), nullptr, false);
    manifest.whole_bytes = end + 1;

    if (!entry.is_object() || !entry["scan"].is_string()) continue;
    std::optional<std::uint64_t> window;
    if (entry.contains("window")) {
      if (!entry["window"].is_number_unsigned()) continue;
      window = entry["window"].get<std::uint64_t>();
    }

    const std::string path = entry["scan"];
    manifest.entries.insert_or_assign({path, window}, std::move(entry));
    ++manifest.lines;
  }

  return manifest;
}

Manifest read_manifest(const fs::path& path) {
  if (!fs::exists(path)) return {};
  const std::vector<std::uint8_t> bytes = read_file(path);
  return manifest_from({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, path.string());
}

nlohmann::json entry_for(const ScanName& scan, const std::vector<std::string>& settings) {
  nlohmann::json entry = {
      {"scan", scan.path}, {"settings", settings}, {"version", SLIPSTREAM_VERSION}};
  if (scan.window) entry["window"] = *scan.window;
  return entry;
}

std::string line_of(const nlohmann::json& entry) {
  return entry.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

nlohmann::json sums_of(const std::vector<std::string>& paths) {
  nlohmann::json sums = nlohmann::json::array();
  for (const std::string& path : paths) {
    const bool there = fs::is_regular_file(path);
    sums.push_back(there ? nlohmann::json{{"path", path},
                                          {"bytes", fs::file_size(path)},
                                          {"crc32", fmt::format("{:08x}", checksum_of_file(path))}}
                         : nlohmann::json());
  }

  return sums;
}

std::string why_not_done(const Manifest& manifest, const ScanName& scan,
                         const nlohmann::json& expected, const std::vector<std::string>& outputs) {
  const auto found = manifest.entries.find(scan);
  if (found == manifest.entries.end()) return "not done yet";

  const nlohmann::json& entry = found->second;
  if (entry.contains("error")) return entry["error"].is_string() ? entry["error"] : "failed";

  // The same input, settings and version, and outputs that are still as they were written.
  for (const auto& [key, value] : expected.items()) {
    if (!entry.contains(key) || entry[key] != value) return "done with a different " + key;
  }

  const bool whole = entry.contains("outputs") && entry["outputs"] == sums_of(outputs);
  return whole ? "" : "its outputs were changed since";
}

}  // namespace slipstream::app
