#include "check/wrapped_levels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <set>
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

/// The first frame of a run that jumps between two pixels by nearly the whole range, if few do, all
/// the same way, and the others hardly differ; otherwise -1. Phases and edges of surfaces change
/// most steps.
int jumping_frame(const StepRun& run, const float* here, const float* there) {
  constexpr float jump = 150, hardly = 20;  // grey levels of 255
  constexpr double few = 0.4;

  int up = 0, down = 0, first = -1;
  for (int n = run.first; n < run.first + run.steps; ++n) {
    const float change = there[n] - here[n];
    if (change > jump) {
      ++up;
    } else if (change < -jump) {
      ++down;
    } else if (std::abs(change) > hardly) {
      return -1;
    }
    if (first < 0 && std::abs(change) > jump) first = n;
  }

  const int jumps = up + down;
  if (!has_level_between(run, here) || !has_level_between(run, there)) return -1;
  return std::min(up, down) == 0 && jumps <= few * run.steps ? first : -1;
}

}  // namespace

std::optional<Finding> wrapped_levels(const Layout& layout, const ScanSamples& samples) {
  constexpr int fewest = 6;
  const std::vector<StepRun> runs = step_runs(layout);

  std::size_t steps = 0;
  for (const StepRun& run : runs) steps += static_cast<std::size_t>(run.steps);

  int jumps = 0;
  std::set<int> frames;  // the first to jump in each run
  for (std::size_t g = 0; g < samples.groups(); ++g) {
    for (const auto place : {ScanSamples::right, ScanSamples::below}) {
      if (!samples.lit(g, place)) continue;

      const float* const here = samples.levels(g, ScanSamples::middle);
      const float* const there = samples.levels(g, place);
      bool jumped = false;
      for (const StepRun& run : runs) {
        const int frame = jumping_frame(run, here, there);
        if (frame < 0) continue;
        jumped = true;
        frames.insert(frame);
      }
      if (jumped) ++jumps;
    }
  }

  // Levels wrap where the light is brightest, in one frame here and in another there. Few frames
  // that were shaken jump at edges of the object.
  const bool few_frames = 2 * frames.size() < steps;
  if (jumps < fewest || few_frames) return std::nullopt;

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
