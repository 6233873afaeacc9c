#include "app/save_scan.h"

#include <chrono>
#include <ctime>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "app/simulate_boards.h"
#include "slipstream/error/error.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/photometric_file.h"
#include "slipstream/io/preview.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/live/window_frames.h"
#include "slipstream/reconstruct/reconstructor.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

/// "scan-20260131-142530", with -2, -3 and so on where there is one already.
fs::path new_folder(const fs::path& parent) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  const std::string name = fmt::format("scan-{:%Y%m%d-%H%M%S}", fmt::localtime(now));
  fs::path folder = parent / name;
  for (int copy = 2; fs::exists(folder); ++copy) {
    folder = parent / fmt::format("{}-{}", name, copy);
  }
  make_folder(folder);
  return folder;
}

void write_frames_and_scanner(const fs::path& folder, const FrameSet& frames,
                              const LiveScan& live) {
  ScanDescription scan;
  scan.strategy = live.strategy;
  scan.axis = live.axis;
  scan.light = live.settings.cue.light;
  scan.projector = live.scanner.projector.size;
  scan.bits = frames.bits();
  scan.frames = frame_names(folder, frames);
  scan.scanner = folder / "scanner.yaml";
  write_frames(scan.frames, frames);
  write_scanner(*scan.scanner, live.scanner);
  write_photometric_calibration(
      scan.scanner, *scan.scanner,
      {.ambient = live.settings.cue.ambient, .noise_variance = live.settings.cue.noise_variance});
  write_scan_description(folder / "scan.yaml", scan);
}

}  // namespace

std::string save_scan(const LiveCloud& cloud, const LiveScan& scan, const fs::path& parent) {
  if (static_cast<int>(cloud.frames.size()) != frame_count(scan.strategy)) {
    throw Error("the frames shown are not of the strategy looked for");
  }
  const FrameSet frames = frame_set_of(cloud.frames);
  const Reconstruction result =
      Reconstructor(scan.scanner, scan.strategy, scan.axis, scan.settings)(frames);
  const fs::path folder = new_folder(parent);
  write_frames_and_scanner(folder, frames, scan);
  write_cloud(folder / "cloud.ply", result.cloud);
  write_map(folder / "depth.tiff", result.cloud.z);
  write_map(folder / "coordinate.tiff", result.decoded.coordinate);
  write_map(folder / "phase.tiff", result.decoded.wrapped_phase);
  write_map(folder / "modulation.tiff", result.decoded.modulation);
  write_map(folder / "mean.tiff", result.decoded.mean);
  write_depth_preview(folder / "preview.png", result.cloud);
  return folder.string();
}

}  // namespace slipstream::app
