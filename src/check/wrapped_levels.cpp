#include "check/wrapped_levels.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace slipstream {
namespace {

/// Whether a run shows a level between dark and bright, as sinusoids do, and stripes of one bit do
/// not.
bool has_level_between(const StepRun& run, const float* levels) {
  constexpr float least = 0.25F, most = 0.75F;  // of the range
  const float* const first = levels + run.first;
  const auto [darkest, brightest] = std::minmax_element(first, first + run.steps);
  const float range = *brightest - *darkest, base = *darkest;

  return std::any_of(first, first + run.steps, [&](float level) {
    return level > base + least * range && level < base + most * range;
  });
}

/// Whether few steps of a run differ between two pixels by nearly the whole range, all the same
/// way, and the others hardly. Phases and edges of surfaces change most steps.
bool is_jump(const StepRun& run, const float* here, const float* there) {
  constexpr float jump = 150, hardly = 20;  // grey levels of 255
  constexpr double few = 0.4;

  int up = 0, down = 0;
  for (int n = run.first; n < run.first + run.steps; ++n) {
    const float change = there[n] - here[n];
    if (change > jump) {
      ++up;
    } else if (change < -jump) {
      ++down;
    } else if (std::abs(change) > hardly) {
      return false;
    }
  }

  const int jumps = up + down;
  if (!has_level_between(run, here) || !has_level_between(run, there)) return false;
  return std::min(up, down) == 0 && jumps > 0 && jumps <= few * run.steps;
}

}  // namespace

std::optional<Finding> wrapped_levels(const Layout& layout, const ScanSamples& samples) {
  constexpr int fewest = 6;
  const std::vector<StepRun> runs = step_runs(layout);

  int jumps = 0;
  for (std::size_t g = 0; g < samples.groups(); ++g) {
    for (const auto place : {ScanSamples::right, ScanSamples::below}) {
      if (!samples.lit(g, place)) continue;

      const float* const here = samples.levels(g, ScanSamples::middle);
      const float* const there = samples.levels(g, place);
      const bool jumped =
          std::ranges::any_of(runs, [&](const StepRun& run) { return is_jump(run, here, there); });
      if (jumped) ++jumps;
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
