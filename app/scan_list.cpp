#include "app/scan_list.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/recorded_cycle.h"
#include "slipstream/io/recording.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

/// With paths as from where the program runs: in the list they are relative to it.
std::vector<ListedScans> scans_in_list(const fs::path& list) {
  const std::vector<std::uint8_t> bytes = read_file(list);
  std::vector<ListedScans> scans =
      scan_list_from({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, list.string());
  for (ListedScans& listed : scans) listed.path = (list.parent_path() / listed.path).string();
  return scans;
}

void set_end(ListedScans& listed, const ScanChanges& changes) {
  const std::string& path = listed.path;
  if (!is_recording(path)) {
    if (fs::exists(path)) throw Error(fmt::format("{}: windows are of recordings", path));
    return listed.windows.reset();  // who reads it says why, and goes on
  }
  std::uint64_t count = 0;
  try {
    count = window_count(RecordingReader(path), scan_files_in(path, changes).sequence);
  } catch (const Error&) {
    return listed.windows.reset();
  }
  if (listed.windows->first >= count) {
    throw Error(fmt::format("{}: {} windows; none is in {}:", path, count, listed.windows->first));
  }
  listed.windows->end = std::min(listed.windows->end, count);
}

}  // namespace

std::vector<ListedScans> listed_scans(const ReconstructFlags& flags) {
  if (flags.every < 1) throw Error("--every 0 is out of range; 1 or more");
  std::vector<ListedScans> scans;
  for (const std::string& path : flags.paths) {
    if (lower_case_extension(path) != ".txt") {
      scans.push_back({.path = path});
      continue;
    }
    const std::vector<ListedScans> listed = scans_in_list(path);
    scans.insert(scans.end(), listed.begin(), listed.end());
  }
  for (ListedScans& listed : scans) {
    if (flags.windows && !listed.windows) {
      listed.windows = window_range_from(*flags.windows);
      listed.cost = 0;
    }
    const bool known =
        listed.cost > 0 && listed.windows && listed.windows->end != WindowRange::last;
    if (listed.windows && !known) set_end(listed, changes_of(flags.cloud.input));
  }
  return scans;
}

}  // namespace slipstream::app
