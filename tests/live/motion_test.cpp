// Clouds of things that move, each of more frames than a cycle.
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/frames/window_frames.h"
#include "slipstream/live/live_pipeline.h"
#include "slipstream/reconstruct/engine.h"
#include "tests/live/virtual_loop.h"

namespace slipstream::motion_test {
using namespace std::chrono_literals;

/// Largest difference of depth, mm; where only one has a point it is infinite.
double largest_difference(const Cloud& a, const Cloud& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.z.pixel_count(); ++i) {
    const double z = a.z.begin()[i], other = b.z.begin()[i];
    if (std::isnan(z) && std::isnan(other)) continue;
    const double apart = std::abs(z - other);
    largest = std::isnan(apart) ? INFINITY : std::max(largest, apart);
  }
  return largest;
}

TEST(LiveMotion, gives_a_cloud_for_each_frame_wherever_its_window_begins) {
  constexpr std::uint64_t frames = 40;
  for (const int steps : {3, 4}) {
    const Strategy cycle = PhaseMeasuring{
        .steps = steps, .frequency = 1, .shifts = {.origin = 2.1, .backwards = steps == 3}};
    EngineSetup setup{example_scanner({64, 48}),
                      {.strategy = cycle, .motion = 2},
                      {.clean = CleanSettings::none()}};
    // Nothing moves and there is next to no noise: every window sees what a cycle does.
    const std::vector<Frame> loop = frames_of(
        cycle, {.cycles = 2, .photometry = {.ambient = 5, .noise_variance = 1e-3, .bits = 12}});
    Cloud still;
    std::vector<Image<std::uint16_t>> one;
    for (int n = 0; n < steps; ++n) {
      one.push_back(std::get<Image<std::uint16_t>>(loop[static_cast<std::size_t>(n)].pixels));
    }
    Engine(setup.scanner, {.strategy = cycle}, setup.settings).cloud(FrameSet(one, 12), still);

    std::vector<int> begun(static_cast<std::size_t>(steps));
    double largest = 0;
    LivePipeline pipeline(std::make_unique<VirtualCamera>(loop), setup,
                          {.indexing = PatternIndexing::counted,
                           .most_frames = frames,
                           .on_cloud = [&](const Pooled<LiveCloud>& live) {
                             ++begun[static_cast<std::size_t>(live->first_pattern)];
                             largest = std::max(largest, largest_difference(live->cloud, still));
                           }});
    pipeline.start();
    while (pipeline.running()) std::this_thread::sleep_for(1ms);
    pipeline.stop();
    EXPECT_EQ(pipeline.failure(), nullptr);
    EXPECT_EQ(pipeline.statistics().clouds, frames - static_cast<std::uint64_t>(steps) - 1);
    for (const int count : begun) EXPECT_GE(count, 8);
    // A window taken for one that begins elsewhere is off by hundreds.
    EXPECT_LT(largest, 3) << steps << " steps";
    EXPECT_EQ(pipeline.newest()->first_pattern, 0);
    for (const LiveFinding& told : pipeline.findings()) ADD_FAILURE() << told.finding.what;
  }
}

}  // namespace slipstream::motion_test
