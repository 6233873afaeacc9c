#include "check/wrapped_levels.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/statistics.h"

namespace slipstream {

std::optional<Finding> wrapped_levels(const Layout& layout, const ScanSamples& samples) {
  // Grey levels of 255: neighbours differ in some frame by nearly the whole range, and in many by
  // hardly anything. Correct scans have no such place, as an edge changes most frames.
  constexpr float jump = 150, hardly = 20;
  constexpr double many = 0.4;
  constexpr int fewest = 6;

  const std::vector<int> frames = measuring_frames(layout);
  if (frames.empty()) return std::nullopt;

  int jumps = 0;
  std::vector<float> differences;
  for (std::size_t g = 0; g < samples.groups(); ++g) {
    for (const auto place : {ScanSamples::right, ScanSamples::below}) {
      if (!samples.lit(g, place)) continue;

      const float* const here = samples.levels(g, ScanSamples::middle);
      const float* const there = samples.levels(g, place);
      differences.clear();
      for (const int n : frames) differences.push_back(std::abs(here[n] - there[n]));

      const float most = *std::ranges::max_element(differences);
      if (most > jump && quantile(differences, many) < hardly) ++jumps;
    }
  }

  if (jumps < fewest) return std::nullopt;

  return Finding{
      .kind = FindingKind::clipped,
      .severity = Severity::wrong,
      .what = "bright grey levels begin again at 0",
      .evidence = {{.name = "jumps between neighbours",
                    .value = static_cast<double>(jumps),
                    .limit = static_cast<double>(fewest)}},
      .causes = {{CauseKind::clipped_pictures,
                  "levels above the highest that wrapped around before they were saved, as in "
                  "arithmetic with 8-bit integers"}},
      .remedies = {{"save the camera's frames unchanged, or clip them before the conversion"}}};
}

}  // namespace slipstream
