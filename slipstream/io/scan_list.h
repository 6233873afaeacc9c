#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/io/result_files.h"

namespace slipstream {

/// Windows of a recording, `end` not among them.
struct WindowRange {
  static constexpr std::uint64_t last = UINT64_MAX;  ///< as `end`: to the last

  std::uint64_t first = 0, end = last;

  friend bool operator==(const WindowRange&, const WindowRange&) = default;
};

/// "A:B", "A:", ":B", ":", or "A" for that one. Throws Error for any other text.
WindowRange window_range_from(std::string_view text);

/// A line of a list: a folder or a recording as one scan, or windows of a recording.
struct ListedScans {
  std::string path{};
  std::optional<WindowRange> windows{};
  std::uint64_t cost = 0;   ///< of all of them: pixels of their frames; 0 where not known
  std::uint64_t shard = 0;  ///< of a batch, from 1; 0 where of none

  friend bool operator==(const ListedScans&, const ListedScans&) = default;
};

/// The text of a list: a line for each, PATH, A:B, COST and SHARD with tabs between; what is not
/// known is empty, and the last of them may be left out. Throws Error, naming file and line, for
/// what is no such line, calling the file `name`; lines with nothing in them are passed over.
std::vector<ListedScans> scan_list_from(std::string_view text, const std::string& name);
/// Throws Error for a path that has a tab or a line end in it.
std::string text_of(const std::vector<ListedScans>& scans);

/// How many scans they are, of their windows every so many. The range has an end.
std::uint64_t scan_count(const ListedScans& scans, std::uint64_t every);

/// Each by itself. Throws Error where they are more than most_scans.
std::vector<ScanName> scan_names(const std::vector<ListedScans>& scans, std::uint64_t every);

/// Cuts them, one behind another, into so many shards, at least 1, whose costs differ from their
/// mean by those of one scan at most. All have a cost, and ranges have an end.
std::vector<ListedScans> cut_into_shards(const std::vector<ListedScans>& scans, std::uint64_t every,
                                         std::uint64_t shards);

}  // namespace slipstream
