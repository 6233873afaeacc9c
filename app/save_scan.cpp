#include "app/save_scan.h"

#include <algorithm>
#include <chrono>
#include <ctime>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "app/simulate_boards.h"
#include "slipstream/error/error.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/preview.h"
#include "slipstream/io/response_file.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/live/window_frames.h"
#include "slipstream/reconstruct/reconstructor.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

bool same(const PhaseCorrections& a, const PhaseCorrections& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& one, const auto& other) {
    return one.first == other.first && one.second.added == other.second.added;
  });
}

/// The scanner's text, with the gamma that was chosen where that is not the one in it.
std::string text_with_gamma(const SavedScanner& scanner, const PhaseCorrections& corrections) {
  const std::string text =
      with_photometric_calibration(scanner.text, scanner.photometry, scanner.name);
  const auto chosen =
      std::find_if(scanner.gammas.begin(), scanner.gammas.end(),
                   [&](const GammaChoice& gamma) { return same(gamma.corrections, corrections); });
  if (chosen == scanner.gammas.end() || chosen->source == "scanner file") return text;
  return with_gamma(text, corrections.empty() ? std::nullopt : chosen->gamma, scanner.name);
}

void write_frames_and_scanner(const fs::path& folder, const FrameSet& frames, const LiveScan& live,
                              const SavedScanner& scanner) {
  const std::string text = text_with_gamma(scanner, live.settings.phase_corrections);
  const bool xml = text.find_first_not_of(" \t\r\n") == text.find('<');
  ScanDescription scan;
  scan.strategy = live.strategy;
  scan.axis = live.axis;
  scan.light = live.settings.cue.light;
  scan.projector = live.scanner.projector.size;
  scan.bits = frames.bits();
  scan.frames = frame_names(folder, frames);
  scan.scanner = folder / (xml ? "scanner.xml" : "scanner.yaml");
  write_frames(scan.frames, frames);
  write_file(*scan.scanner, text);
  write_scan_description(folder / "scan.yaml", scan);
}

}  // namespace

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

std::string save_scan(const LiveCloud& cloud, const LiveScan& scan, const SavedScanner& scanner,
                      const fs::path& parent) {
  if (static_cast<int>(cloud.frames.size()) != frame_count(scan.strategy)) {
    throw Error("the frames shown are not of the strategy looked for");
  }
  const FrameSet frames = frame_set_of(cloud.frames);
  const Reconstruction result =
      Reconstructor(scan.scanner, scan.strategy, scan.axis, scan.settings)(frames);
  const fs::path folder = path_named_by_time(parent, "scan", "");
  make_folder(folder);
  write_frames_and_scanner(folder, frames, scan, scanner);
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
