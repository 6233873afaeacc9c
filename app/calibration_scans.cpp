#include "app/calibration_scans.h"

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream::app {
namespace fs = std::filesystem;

ScanDescription describe_scan(const fs::path& folder, const ScanFlags& flags) {
  ScanDescription scan;
  if (fs::exists(folder / "scan.yaml")) {
    scan = read_scan_description(folder / "scan.yaml");
  } else if (!flags.strategy) {
    throw Error(fmt::format("{}: no scan.yaml in it; say what the pictures are with --strategy",
                            folder.string()));
  } else {
    scan.frames = images_in_folder(folder);
  }
  scan.strategy = strategy_from(flags, scan.strategy);
  scan.light = light_from(flags, scan.light);
  const int wanted = frame_count(scan.strategy);
  if (static_cast<int>(scan.frames.size()) != wanted) {
    throw Error(fmt::format("{}: {} frames, but {} with these steps takes {}", folder.string(),
                            scan.frames.size(), name_of(scan.strategy), wanted));
  }
  return scan;
}

void add_calibration_files(CLI::App& command, CalibrationFiles& files) {
  command.add_option("--scanner", files.scanner,
                     "scanner file to add to; where not that of scan.yaml");
  command.add_option("-o,--output", files.output, "the scanner file to write: .yaml or .xml");
}

Image<std::uint8_t> unclipped(const FrameSet& frames) {
  Image<std::uint8_t> good(frames.size(), 1);
  const double brightest = frames.quantised() ? frames.full_scale() : 1e300;
  frames.visit([&](const auto& views) {
    for (const auto& view : views) {
      for (int row = 0; row < view.height(); ++row) {
        for (int column = 0; column < view.width(); ++column) {
          const auto level = static_cast<double>(view(column, row));
          if (level <= 0 || level >= brightest) good(column, row) = 0;
        }
      }
    }
  });
  return good;
}

}  // namespace slipstream::app
