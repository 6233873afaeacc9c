#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

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

}  // namespace slipstream
