#include "app/scan_list.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/io/recorded_cycle.h"
#include "slipstream/io/recording.h"

namespace slipstream::app {
namespace {

/// A whole number of A:B; `otherwise` where there is none.
std::uint64_t window_from(std::string_view number, std::uint64_t otherwise,
                          const std::string& range) {
  std::uint64_t window = otherwise;
  const auto [end, failure] = std::from_chars(number.data(), number.data() + number.size(), window);
  if (number.empty() || (failure == std::errc() && end == number.data() + number.size())) {
    return window;
  }
  throw Error(fmt::format("--windows '{}' is no range; give A:B, as 0:100, 100: or :", range));
}

}  // namespace

std::vector<ScanName> scans_of(const std::vector<std::string>& paths,
                               const std::optional<std::string>& windows, std::uint64_t every,
                               const ScanChanges& changes) {
  if (!windows) return {paths.begin(), paths.end()};
  const std::string& range = *windows;
  const std::size_t colon = std::min(range.find(':'), range.size());
  constexpr auto none = std::numeric_limits<std::uint64_t>::max();
  const std::string_view text = range;
  const std::uint64_t first = window_from(text.substr(0, colon), 0, range);
  const std::uint64_t last =
      colon == range.size() ? first + 1 : window_from(text.substr(colon + 1), none, range);
  if (every < 1) throw Error("--every 0 is out of range; 1 or more");
  std::vector<ScanName> scans;
  for (const std::string& path : paths) {
    if (!is_recording(path)) throw Error(fmt::format("{}: --windows is of recordings", path));
    const Sequence shown = scan_files_in(path, changes).sequence;
    const std::uint64_t count = window_count(RecordingReader(path), shown);
    if (first >= count) {
      throw Error(fmt::format("{}: {} windows; none is in --windows {}", path, count, range));
    }
    for (std::uint64_t window = first; window < std::min(last, count);) {
      scans.push_back({path, window});
      if (every >= count - window) break;
      window += every;
    }
  }
  return scans;
}

}  // namespace slipstream::app
