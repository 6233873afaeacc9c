#include "slipstream/io/saved_scan.h"

#include <chrono>
#include <cmath>
#include <ctime>
#include <string>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/preview.h"
#include "slipstream/io/scanner_file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

std::string folder_of(const ScanFiles& files) {
  return files.frames.empty() ? "the scan" : files.frames.front().parent_path().string();
}

}  // namespace

Scan load_frames(const ScanFiles& files) {
  const int wanted = frame_count(files.sequence);
  if (static_cast<int>(files.frames.size()) != wanted) {
    throw Error(fmt::format("{}: {} frames, but {} with these steps and exposures takes {}",
                            folder_of(files), files.frames.size(), files.sequence.strategy.name(),
                            wanted));
  }
  LoadedFrames loaded = read_frames(files.frames, files.bits);
  return merged({.frames = std::move(loaded.frames),
                 .sequence = files.sequence,
                 .warnings = std::move(loaded.warnings)});
}

Scan load_scan(const ScanFiles& files) {
  Scan scan = load_frames(files);
  if (files.scanner) {
    scan.scanner = completed(read_scanner(*files.scanner), files.scanner->string(),
                             scan.frames.size(), files.sequence.projector);
    scan.sequence.projector = scan.scanner->projector.size;
  }
  return scan;
}

void add_camera(Scan& scan, const ScanFiles& files) {
  Scan further = load_scan(files);
  if (further.sequence.strategy != scan.sequence.strategy ||
      further.sequence.axis != scan.sequence.axis) {
    throw Error(fmt::format("{}: another strategy than the first camera's; both see one projector",
                            folder_of(files)));
  }
  scan.further_cameras.push_back(std::move(further));
}

Scan load_scan(const fs::path& folder) {
  const ScanFiles files = read_scan_files(folder / "scan.yaml");
  Scan scan = load_scan(files);
  if (files.second_camera) add_camera(scan, read_scan_files(*files.second_camera / "scan.yaml"));
  return scan;
}

std::vector<fs::path> frame_names(const fs::path& folder, const FrameViews& frames) {
  std::vector<fs::path> names;
  for (int n = 0; n < frames.count(); ++n) {
    names.push_back(folder / fmt::format("frame_{:02}.{}", n, frames.quantised() ? "png" : "tiff"));
  }
  return names;
}

ScanFiles save_scan(const fs::path& folder, const FrameViews& frames, const Sequence& sequence,
                    const std::optional<Scanner>& scanner,
                    const std::optional<fs::path>& scanner_file) {
  make_folder(folder);
  ScanFiles files{.sequence = sequence,
                  .bits = frames.quantised() ? frames.bits() : 0,
                  .frames = frame_names(folder, frames),
                  .scanner = scanner_file};
  write_frames(files.frames, frames);
  if (scanner && !scanner_file) {
    files.scanner = folder / "scanner.yaml";
    write_scanner(*files.scanner, *scanner);
  }
  write_scan_files(folder / "scan.yaml", files);
  return files;
}

void save_results(const fs::path& folder, const Cloud& cloud, const Maps& maps) {
  write_cloud(folder / "cloud.ply", cloud);
  write_map(folder / "depth.tiff", cloud.z);
  write_map(folder / "coordinate.tiff", maps.coordinate);
  write_map(folder / "phase.tiff", maps.wrapped_phase);
  write_map(folder / "modulation.tiff", maps.modulation);
  write_map(folder / "mean.tiff", maps.mean);
  write_depth_preview(folder / "preview.png", cloud);
}

fs::path path_named_by_time(const fs::path& parent, std::string_view what,
                            std::string_view ending) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  const std::string name = fmt::format("{}-{:%Y%m%d-%H%M%S}", what, fmt::localtime(now));
  fs::path path = parent / fmt::format("{}{}", name, ending);
  for (int copy = 2; fs::exists(path); ++copy) {
    path = parent / fmt::format("{}-{}{}", name, copy, ending);
  }
  return path;
}

std::optional<double> error_against_truth(const fs::path& folder, const Cloud& cloud) {
  const fs::path file = folder / "truth" / "depth.tiff";
  if (!fs::exists(file)) return std::nullopt;
  const Image<double> truth = read_map(file);
  if (truth.size() != cloud.size()) {
    throw Error(fmt::format("{} is {}, the frames are {}; both must agree", file.string(),
                            text_of(truth.size()), text_of(cloud.size())));
  }
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < truth.pixel_count(); ++i) {
    const double difference = cloud.z.begin()[i] - truth.begin()[i];
    if (!std::isfinite(difference)) continue;
    sum += difference * difference;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / static_cast<double>(count));
}

}  // namespace slipstream
