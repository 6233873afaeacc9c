#include "slipstream/io/scan_list.h"

#include <algorithm>
#include <charconv>
#include <system_error>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/io/file.h"

namespace slipstream {
namespace {

/// What stands before the mark, which is taken off with it; all where there is none.
std::string_view take(std::string_view& text, char mark) {
  const std::size_t end = std::min(text.find(mark), text.size());
  const std::string_view taken = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return taken;
}

/// A whole number, `otherwise` where there is nothing.
std::optional<std::uint64_t> number_from(std::string_view text, std::uint64_t otherwise) {
  std::uint64_t number = otherwise;
  const char* const end = text.data() + text.size();
  if (text.empty()) return otherwise;
  const auto [read, failure] = std::from_chars(text.data(), end, number);
  return read == end && failure == std::errc() ? std::optional(number) : std::nullopt;
}

ListedScans listed_from(std::string_view line) {
  ListedScans scans{.path = std::string(take(line, '\t'))};
  const std::string_view windows = take(line, '\t');
  if (!windows.empty()) scans.windows = window_range_from(windows);
  const auto cost = number_from(take(line, '\t'), 0), shard = number_from(take(line, '\t'), 0);
  constexpr std::uint64_t exact = std::uint64_t{1} << 53;  // in a double
  if (scans.path.empty() || !cost || *cost > exact || !shard || !line.empty()) {
    throw Error("is no line of a list: PATH, A:B, COST and SHARD with tabs between");
  }
  scans.cost = *cost;
  scans.shard = *shard;
  return scans;
}

}  // namespace

WindowRange window_range_from(std::string_view text) {
  std::string_view rest = text;
  const auto first = number_from(take(rest, ':'), 0);
  const bool is_one = text.find(':') == std::string_view::npos;
  const auto end = is_one && first ? *first + 1 : number_from(rest, WindowRange::last);
  if (text.empty() || !first || !end || *end <= *first) {
    throw Error(fmt::format("'{}' is no range of windows; give A:B, as 0:100, 100: or :", text));
  }
  return {*first, *end};
}

std::vector<ListedScans> scan_list_from(std::string_view text, const std::string& name) {
  std::vector<ListedScans> scans;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = take(text, '\n');
    if (line.empty()) continue;
    try {
      scans.push_back(listed_from(line));
    } catch (const Error& error) {
      throw Error(fmt::format("{}: line {}: {}", name, number, error.what()));
    }
  }
  return scans;
}

std::string text_of(const std::vector<ListedScans>& scans) {
  std::string text;
  for (const auto& [path, windows, cost, shard] : scans) {
    if (path.find_first_of("\t\n") != std::string::npos) {
      throw Error(fmt::format("{}: a list takes no name with a tab or a line end", path));
    }
    text += path;
    text += '\t';
    if (windows) text += fmt::format("{}:", windows->first);
    if (windows && windows->end != WindowRange::last) text += fmt::format("{}", windows->end);
    text += fmt::format("\t{}\t{}\n", cost, shard);
  }
  return text;
}

std::uint64_t scan_count(const ListedScans& scans, std::uint64_t every) {
  if (!scans.windows) return 1;
  return (scans.windows->end - scans.windows->first - 1) / every + 1;
}

std::vector<ScanName> scan_names(const std::vector<ListedScans>& scans, std::uint64_t every) {
  std::vector<ScanName> names;
  for (const ListedScans& listed : scans) {
    const std::uint64_t count = scan_count(listed, every);
    if (count > most_scans - names.size()) {
      throw Error(fmt::format("{}: more than {} scans", listed.path, most_scans));
    }
    if (!listed.windows) names.push_back({listed.path});
    for (std::uint64_t i = 0; listed.windows && i < count; ++i) {
      names.push_back({listed.path, listed.windows->first + i * every});
    }
  }
  return names;
}

std::vector<ListedScans> cut_into_shards(const std::vector<ListedScans>& scans, std::uint64_t every,
                                         std::uint64_t shards) {
  double all = 0, before = 0;
  for (const ListedScans& listed : scans) all += static_cast<double>(listed.cost);
  std::vector<ListedScans> pieces;
  for (const ListedScans& listed : scans) {
    const std::uint64_t count = scan_count(listed, every);
    const double cost = static_cast<double>(listed.cost) / static_cast<double>(count);
    for (std::uint64_t i = 0; i < count; ++i, before += cost) {
      // A scan is of the shard that its middle lies in.
      const double place = (before + cost / 2) / all * static_cast<double>(shards);
      const std::uint64_t shard = std::min(static_cast<std::uint64_t>(place) + 1, shards);
      if (i == 0 || shard != pieces.back().shard) {
        pieces.push_back({.path = listed.path, .windows = listed.windows, .shard = shard});
        if (listed.windows) pieces.back().windows->first += i * every;
      }
      pieces.back().cost += static_cast<std::uint64_t>(cost);
      if (!listed.windows) continue;
      pieces.back().windows->end =
          std::min(listed.windows->end, listed.windows->first + (i + 1) * every);
    }
  }
  return pieces;
}

}  // namespace slipstream
