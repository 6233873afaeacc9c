#include "slipstream/decode/frame_adapter.h"

#include <cstddef>
#include <utility>

namespace slipstream {
namespace {

/// The runs of steps by which a cycle's first frame is found, from few periods to many; none unless
/// there are two or more and nothing else.
std::vector<CycleRun> cycle_runs(const Layout& layout) {
  std::vector<CycleRun> runs;
  int covered = 0;
  for (const std::size_t i : coarse_to_fine(layout)) {
    const auto run = step_run(layout.bands[i]);
    if (!run) break;
    covered += run->steps;
    runs.push_back({run->first, channel_cosines(run->steps, 1), channel_sines(run->steps, 1)});
  }
  if (runs.size() < 2 || covered != layout.frames) runs.clear();
  return runs;
}

}  // namespace

FrameAdapter::FrameAdapter(const Sequence& sequence) : read_(sequence.strategy.layout().frames) {
  if (sequence.exposures.size() > 1) exposures_ = sequence.exposures;
  if (const auto how = sequence.strategy.demodulation()) demodulate_.emplace(*how, sequence.axis);
}

const FrameViews& FrameAdapter::operator()(const FrameViews& taken) {
  if (demodulate_ && taken.count() != read_) return (*demodulate_)(taken);
  if (exposures_.empty() || taken.merged()) return taken;
  merge_exposures(taken, exposures_, merged_);
  return merged_.views;
}

bool needs_adapting(const Sequence& sequence) {
  return frame_count(sequence) != frame_count(sequence.strategy) ||
         sequence.strategy.demodulation();
}

std::vector<FrameSet> adapted(const Sequence& sequence, FrameSet taken) {
  if (sequence.exposures.size() > 1) taken = merged_exposures(taken, sequence.exposures);
  std::vector<FrameSet> scans;
  if (sequence.both_axes) {
    auto [first, second] = halves(std::move(taken));
    scans.push_back(std::move(first));
    scans.push_back(std::move(second));
  } else {
    scans.push_back(std::move(taken));
  }
  if (const auto how = sequence.strategy.demodulation()) {
    Axis axis = sequence.both_axes ? Axis::x : sequence.axis;
    for (FrameSet& frames : scans) {
      frames = demodulated(*how, axis, frames);
      axis = across(axis);
    }
  }
  return scans;
}

PatternCycle pattern_cycle(const Sequence& sequence, int scans) {
  return {.patterns = scans * frame_count(cycle_of(sequence)),
          .extra = sequence.motion,
          .runs = scans == 1 ? cycle_runs(sequence.strategy.layout()) : std::vector<CycleRun>{}};
}

}  // namespace slipstream
