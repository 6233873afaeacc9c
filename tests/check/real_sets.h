#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "io/image_file.h"
#include "slipstream/scan.h"
#include "slipstream/scanner_file.h"
#include "slipstream/strategy.h"
#include "tests/shared_data.h"

namespace slipstream {

template <class NameOf>
std::vector<std::string> names_of(int count, const NameOf& name_of) {
  std::vector<std::string> names;
  for (int n = 0; n < count; ++n) names.push_back(name_of(n));
  return names;
}

/// Patterns along x, in a folder of real captures; `scanner`: file in it, or null.
inline Scan real_scan(const std::filesystem::path& folder, const std::vector<std::string>& names,
                      const Strategy& strategy, Size projector, const char* scanner = nullptr) {
  std::vector<std::filesystem::path> files;
  for (const std::string& name : names) files.push_back(folder / name);
  Scan scan{.frames = read_frames(files).frames, .sequence = {strategy, Axis::x, {}, projector}};
  if (scanner != nullptr) {
    scan.scanner =
        completed(read_scanner(folder / scanner), scanner, scan.frames.size(), projector);
  }
  return scan;
}

/// The skull of shared/data, without calibrated depths.
inline Scan skull() {
  return real_scan(
      shared_data() / "skull",
      names_of(6, [](int n) { return fmt::format("dual-frequency/frameSeq_{:02}.png", n); }),
      DualFrequency{.steps = 3, .high = 16}, {1824, 1140}, "calibration.xml");
}

/// Depths of the boards of its calibration/, mm, by slipstream calibrate geometry.
inline constexpr DepthRange skull_depths{306, 450};

}  // namespace slipstream
