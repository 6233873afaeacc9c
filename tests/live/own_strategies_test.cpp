// Strategies that are layouts alone, live.
#include "tests/own_strategies.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/frames/window_frames.h"
#include "slipstream/live/live_pipeline.h"
#include "slipstream/reconstruct/engine.h"
#include "tests/live/virtual_loop.h"

namespace slipstream::own_strategies_test {
using namespace std::chrono_literals;

/// Every cloud of a loop of the virtual camera, and how many of them are what an engine makes of
/// the same frames.
struct Made {
  std::size_t clouds = 0, same = 0, with_points = 0;
  std::uint64_t resynchronisations = 0;
};

Made made_live(const Strategy& strategy, std::uint64_t frames, std::size_t begin = 0) {
  std::vector<Frame> loop = frames_of(strategy, {.motion = {0.2, 0, 0}, .cycles = 4});
  std::rotate(loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(begin), loop.end());
  const EngineSetup setup{example_scanner({64, 48}), {.strategy = strategy}, {}};
  Engine alone(setup);
  Made made;
  LivePipeline pipeline(
      std::make_unique<VirtualCamera>(loop), setup,
      {.indexing = PatternIndexing::counted,
       .most_frames = frames,
       .on_cloud = [&](const Pooled<LiveCloud>& live) {
         Cloud expected;
         alone.cloud(views_of(live->frames), expected);
         const std::size_t bytes = expected.z.pixel_count() * sizeof(float);
         ++made.clouds;
         made.with_points += point_count(live->cloud) > 500 ? 1 : 0;
         made.same += std::memcmp(live->cloud.z.begin(), expected.z.begin(), bytes) == 0 ? 1 : 0;
       }});
  pipeline.start();
  while (pipeline.running()) std::this_thread::sleep_for(1ms);
  pipeline.stop();
  EXPECT_EQ(pipeline.failure(), nullptr);
  made.resynchronisations = pipeline.statistics().resynchronisations;
  return made;
}

TEST(LivePipeline, each_frame_gives_a_cloud_of_a_strategy_of_ones_own) {
  for (const Strategy& strategy : own_strategies()) {
    SCOPED_TRACE(strategy.name());
    const auto N = static_cast<std::size_t>(frame_count(strategy));
    const Made made = made_live(strategy, 10 * N);
    EXPECT_EQ(made.clouds, 9 * N + 1);
    EXPECT_EQ(made.same, made.clouds);
    EXPECT_EQ(made.with_points, made.clouds);
    EXPECT_EQ(made.resynchronisations, 0U);
  }
}

}  // namespace slipstream::own_strategies_test
