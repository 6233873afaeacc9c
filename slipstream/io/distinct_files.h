#pragma once

#include <filesystem>
#include <set>

namespace slipstream {

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
