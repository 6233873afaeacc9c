#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/cloud_file.h"
#include "slipstream/maps.h"

namespace slipstream {

/// Output paths of a scan's results; empty: not written.
struct ResultFiles {
  std::string cloud{}, mesh{}, depth{}, coordinate{}, phase{}, modulation{}, mean{}, epipolar{},
      motion{}, reflection{}, preview{};

  /// The paths that are not empty, each with its member's name.
  [[nodiscard]] std::vector<std::pair<const char*, std::string>> named() const;
  /// All files written, including those beside a mesh.
  [[nodiscard]] std::vector<std::string> written() const;
  /// Whether any of them is a map that is not part of the cloud.
  [[nodiscard]] bool any_map() const;
  /// Whether only maps are written that need no scanner.
  [[nodiscard]] bool only_maps() const;
  /// Whether any of them needs points: cloud, mesh, depth, epipolar distance and reflection.
  [[nodiscard]] bool need_points() const;
};

/// A folder or a recording, and optionally a window of it.
struct ScanName {
  std::string path;
  std::optional<std::uint64_t> window{};

  friend auto operator<=>(const ScanName&, const ScanName&) = default;
};

/// "scan.slip, window 12"
std::string text_of(const ScanName& scan);

/// The files of one of several scans: replaces "{name}" in a path by the name of the scan's folder,
/// or of its recording without the ending, and "{window}" by the window in six digits.
ResultFiles files_of_scan(const ResultFiles& files, const ScanName& scan);

/// Existing files that an output or a file beside it would replace. A placeholder stands for any
/// name.
std::vector<std::filesystem::path> files_replaced_by(const std::filesystem::path& output);

/// Whether the file is empty, or begins as files of its ending do; false for formats without a
/// fixed beginning.
bool has_format_of_ending(const std::filesystem::path& file);

/// Throws Error for a cloud or mesh of unknown ending, or if two scans would write to one file.
void require_writable(const ResultFiles& files, const std::vector<ScanName>& scans);

/// Writes the results: cloud with extras, mesh of its points, depth in mm, maps as 32-bit float
/// TIFF, preview as PNG: of the depth, or of modulation and phase if the cloud has no depth, only
/// validity. Depth and preview are the camera's, also if the extras name a frame. Throws as the
/// writer of each.
void write_results(const ResultFiles& files, const Cloud& cloud, const Maps& maps,
                   const CloudExtras& extras = {});

/// Files read and written in one run, compared after resolving links, . and ..
class DistinctFiles {
 public:
  /// A file, a recording, or a scan folder with all files that reading it finds: those of its
  /// scan.yaml and of a second camera, the ground truth, or all pictures; or a folder of such
  /// folders, `levels` deep, as board poses are. Ignores unreadable paths.
  void add_input(const std::filesystem::path& path, int levels = 2);
  /// Throws Error if it, or a file written beside it, is already an input or an output, or may be
  /// an input once "{name}" and "{window}" are replaced.
  void add_output(const std::filesystem::path& path);
  /// A folder for a scan or a report. Throws Error if it is an input or holds one's pictures or
  /// scanner.yaml.
  void add_output_folder(const std::filesystem::path& path);
  /// A scanner file that is read and may be extended.
  void add_scanner(const std::filesystem::path& path);
  /// As add_output, but allows a scanner file that is also read, or a scan folder's.
  void add_scanner_output(const std::filesystem::path& path);

 private:
  std::set<std::filesystem::path> inputs_, scanners_, outputs_;
  std::set<std::filesystem::path> picture_folders_;  ///< all pictures in them are inputs
};

/// Windows of a recording, `end` exclusive.
struct WindowRange {
  static constexpr std::uint64_t last = UINT64_MAX;  ///< as `end`: up to the last

  std::uint64_t first = 0, end = last;

  friend bool operator==(const WindowRange&, const WindowRange&) = default;
};

/// "A:B", "A:", ":B", ":", or "A" for one window. Throws Error for any other text.
WindowRange window_range_from(std::string_view text);

/// A line of a list: a folder or recording as one scan, or windows of a recording.
struct ListedScans {
  std::string path{};
  std::optional<WindowRange> windows{};
  std::uint64_t cost = 0;   ///< total pixels of their frames; 0 if unknown
  std::uint64_t shard = 0;  ///< of a batch, from 1; 0 if not assigned

  friend bool operator==(const ListedScans&, const ListedScans&) = default;
};

/// Parses a list: lines of PATH, A:B, COST and SHARD separated by tabs; unknown values are empty,
/// and trailing ones may be omitted. Ignores empty lines. Throws Error with `name` and the line
/// number for a malformed line.
std::vector<ListedScans> scan_list_from(std::string_view text, const std::string& name);
/// Throws Error for a path with a tab or a line break.
std::string text_of(const std::vector<ListedScans>& scans);

/// Number of scans if every `every`th window is used. The range must have an end.
std::uint64_t scan_count(const ListedScans& scans, std::uint64_t every);

/// The scans one by one. Throws Error for more than most_scans.
std::vector<ScanName> scan_names(const std::vector<ListedScans>& scans, std::uint64_t every);

/// Cuts the scans in order into `shards` shards, at least 1, whose costs differ from their mean by
/// at most one scan's. All must have a cost, and ranges an end.
std::vector<ListedScans> cut_into_shards(const std::vector<ListedScans>& scans, std::uint64_t every,
                                         std::uint64_t shards);

}  // namespace slipstream
