#pragma once

#include <compare>
#include <set>

#include "slipstream/decode/maps.h"
#include "slipstream/io/cloud_file.h"

namespace slipstream {

/// Where to write what was made of a scan; a path that is empty: not at all.
struct ResultFiles {
  std::string cloud{}, mesh{}, depth{}, coordinate{}, phase{}, modulation{}, mean{}, epipolar{},
      motion{}, preview{};

  /// Those that are not empty, each with its name above.
  [[nodiscard]] std::vector<std::pair<const char*, std::string>> named() const;
  /// The files of all of them, those beside a mesh too.
  [[nodiscard]] std::vector<std::string> written() const;
  /// Whether a map is among them that the cloud does not hold.
  [[nodiscard]] bool any_map() const;
};

/// A folder or a recording, and which of its windows.
struct ScanName {
  std::string path;
  std::optional<std::uint64_t> window{};

  friend auto operator<=>(const ScanName&, const ScanName&) = default;
};

/// "scan.slip, window 12"
std::string text_of(const ScanName& scan);

/// The files of one scan of several: "{name}" in a path stands for the name of the scan's folder,
/// or of its recording without the ending, "{window}" for the window in six digits.
ResultFiles files_of_scan(const ResultFiles& files, const ScanName& scan);

/// Throws Error for a cloud or mesh of unknown ending, or where two of the scans would be written
/// to one file.
void require_writable(const ResultFiles& files, const std::vector<ScanName>& scans);

/// Writes them: cloud with its extras, the mesh of its points, depth in mm, the maps as TIFF of
/// 32-bit float, the preview as PNG. Throws as the writer of each.
void write_results(const ResultFiles& files, const Cloud& cloud, const Maps& maps,
                   const CloudExtras& extras = {});

/// Files that are read and written in one run, by whatever names: through links, with . and .. in
/// them.
class DistinctFiles {
 public:
  /// A file, a recording, or a scan folder with the files that its scan.yaml names, those of the
  /// second camera too. What cannot be read is passed over.
  void add_input(const std::filesystem::path& path);
  /// Throws Error where it, or a file that is written beside it, is an input or an output already.
  void add_output(const std::filesystem::path& path);
  /// A scanner file that is read, and may be added to.
  void add_scanner(const std::filesystem::path& path);
  /// As add_output, but it may be a scanner file that is read, or that of a scan folder.
  void add_scanner_output(const std::filesystem::path& path);

 private:
  std::set<std::filesystem::path> inputs_, scanners_, outputs_;
};

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
