#include "slipstream/io/distinct_files.h"

#include <system_error>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/io/surface_file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// One for all names of a file.
fs::path identity(const fs::path& path) {
  std::error_code unknown;
  fs::path whole = fs::weakly_canonical(fs::absolute(path, unknown), unknown);
  return unknown ? path : whole;
}

}  // namespace

void DistinctFiles::add_input(const fs::path& path) {
  std::error_code unknown;
  if (!inputs_.insert(identity(path)).second || !fs::is_directory(path, unknown)) return;
  ScanFiles scan;
  try {
    const fs::path description = path / "scan.yaml";
    inputs_.insert(identity(description));
    if (fs::exists(description, unknown)) {
      scan = read_scan_files(description);
    } else {
      scan.frames = images_in_folder(path);
    }
  } catch (const std::exception&) {
    return;  // who reads it says why
  }
  for (const fs::path& frame : scan.frames) inputs_.insert(identity(frame));
  if (scan.scanner) add_scanner(*scan.scanner);
  if (scan.second_camera) add_input(*scan.second_camera);
}

void DistinctFiles::add_output(const fs::path& path) {
  if (path.empty()) return;
  const fs::path file = identity(path);
  if (inputs_.contains(file)) {
    throw Error(fmt::format("{}: is read, and would be written over; name another", path.string()));
  }
  if (!outputs_.insert(file).second) {
    throw Error(
        fmt::format("{}: two outputs would be written to it; give each its own name, which "
                    "{{name}} in it does with several scans",
                    path.string()));
  }
  for (const fs::path& beside : files_beside(path)) add_output(beside);
}

void DistinctFiles::add_scanner(const fs::path& path) {
  scanners_.insert(identity(path));
  add_input(path);
}

void DistinctFiles::add_scanner_output(const fs::path& path) {
  if (!scanners_.contains(identity(path))) add_output(path);
}

}  // namespace slipstream
