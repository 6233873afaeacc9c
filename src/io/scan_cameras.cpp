#include "io/scan_cameras.h"

#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "base/throw_if-inl.h"
#include "slipstream/scanner_file.h"

namespace slipstream {
namespace fs = std::filesystem;

Scan load_cameras(ScanFiles files, const ScanChanges& changes) {
  // 1. The files of each further camera.
  const std::vector<fs::path>& scanners = changes.further_scanners;
  throw_if(!scanners.empty() && scanners.size() != files.further_cameras.size(),
           "{}: has {} further cameras, and {} scanner files are given for them",
           files.path.string(), files.further_cameras.size(), scanners.size());

  std::vector<ScanFiles> further;
  for (std::size_t i = 0; i < files.further_cameras.size(); ++i) {
    ScanChanges of_camera{.sequence = changes.sequence,
                          .order = changes.order,
                          .window = changes.window,
                          .channel = changes.channel};
    if (!scanners.empty()) of_camera.scanner = scanners[i];
    further.push_back(scan_files_in(files.further_cameras[i], of_camera));
  }

  // 2. A file that calibrates two cameras has no projector, so it is neither scan's own scanner.
  std::optional<Scanner> pair;
  ScanFiles& second = further.front();
  if (further.size() == 1 && files.scanner && is_camera_pair(*files.scanner, !second.scanner)) {
    pair = read_camera_pair(*files.scanner);
    files.scanner.reset();
    second.scanner.reset();
  }

  // 3. The scans.
  Scan scan = load_scan(files);
  scan.camera_pair = std::move(pair);
  for (const ScanFiles& camera : further) {
    const Scan& loaded = scan.further_cameras.emplace_back(load_scan(camera));
    throw_if(loaded.sequence.strategy != scan.sequence.strategy ||
                 loaded.sequence.axis != scan.sequence.axis,
             "{}: its sequence differs from the first camera's; all cameras must see one projector",
             camera.path.string());
  }

  return scan;
}

}  // namespace slipstream
