// Consumers that are slower than the frames.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <future>
#include <mutex>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "live/change_signal.h"
#include "slipstream/live_pipeline.h"
#include "tests/live/scripted_source.h"
#include "tests/live/virtual_loop.h"

namespace slipstream::slow_consumer_test {
using namespace std::chrono_literals;

const Strategy four_steps = PhaseMeasuring{.steps = 4, .frequency = 1};

TEST(SlowConsumerChangeSignal, AChangeBetweenLookAndWaitIsNotMissed) {
  ChangeSignal signal;
  const std::uint64_t seen = signal.count();
  signal.announce();
  signal.wait(seen);
  EXPECT_EQ(signal.count(), seen + 1);
}

TEST(SlowConsumerChangeSignal, WakesAWaitingThreadAndGivesUpInTime) {
  ChangeSignal signal;
  auto woken = std::async(std::launch::async, [&] { signal.wait(0); });
  std::this_thread::sleep_for(5ms);
  signal.announce();
  EXPECT_EQ(woken.wait_for(10s), std::future_status::ready);

  const auto end = std::chrono::steady_clock::now() + 5ms;
  signal.wait(signal.count(), end);
  EXPECT_GE(std::chrono::steady_clock::now(), end);
}

TEST(SlowConsumers, ASourceWithoutPaceGoesOnOnceAHeldCloudIsReleased) {
  std::mutex mutex;
  std::vector<Pooled<LiveCloud>> held;
  LivePipeline pipeline(
      std::make_unique<ScriptedSource>(frames_of(four_steps), in_a_row(200)), scan_of(four_steps),
      {.indexing = PatternIndexing::counted, .on_cloud = [&](const Pooled<LiveCloud>& cloud) {
         const std::lock_guard lock(mutex);
         held.push_back(cloud);
       }});
  pipeline.start();
  while (pipeline.running()) {
    std::this_thread::sleep_for(100us);
    const std::lock_guard lock(mutex);
    held.clear();
  }
  pipeline.stop();
  EXPECT_GT(pipeline.statistics().clouds, 100U);
}

TEST(SlowConsumers, CaptureGoesOnWhileAConsumerHoldsEveryCloud) {
  const auto pictures = frames_of(four_steps);
  const int count = 5000;
  std::vector<Pooled<LiveCloud>> held;
  std::atomic<bool> holding = true;
  std::mutex mutex;
  LiveSettings settings{.indexing = PatternIndexing::counted,
                        .waiting_frames = 8,
                        .on_cloud = [&](const Pooled<LiveCloud>& cloud) {
                          const std::lock_guard lock(mutex);
                          if (holding) held.push_back(cloud);
                        }};
  auto source = std::make_unique<ScriptedSource>(pictures, in_a_row(count), true);
  std::promise<const LivePipeline*> made;
  const LivePipeline* running = nullptr;
  const auto wait_for_windows = [&] {
    while (running->statistics().stages[1].waiting > 0) std::this_thread::sleep_for(100us);
  };
  source->before_step = [&](std::size_t step) {
    const auto last = static_cast<std::size_t>(count) - 500;
    if (step == 1) running = made.get_future().get();
    if (step == last) {
      const std::lock_guard lock(mutex);
      holding = false;
      held.clear();
    }
    // Windows count from the first frame on; at the end each gives a cloud again.
    if (step == 1 || step > last) wait_for_windows();
  };
  LivePipeline pipeline(std::move(source), scan_of(four_steps), settings);
  pipeline.start();
  made.set_value(&pipeline);
  wait_for_end(pipeline);
  const LiveStatistics statistics = pipeline.statistics();
  EXPECT_EQ(statistics.frames.captured, static_cast<std::uint64_t>(count));
  EXPECT_EQ(statistics.frames.lost, 0U);
  EXPECT_GT(statistics.frames.overwritten + statistics.windows_skipped, 1000U);
  EXPECT_GT(statistics.clouds, 450U);
  EXPECT_EQ(statistics.clouds + statistics.windows_lost + statistics.windows_skipped,
            static_cast<std::uint64_t>(count) - 3);
}

class SlowConsumer : public testing::TestWithParam<int> {};

// Shows a frame only when the queue has room, so that no thread's share of time matters.
TEST_P(SlowConsumer, CostsWholeWindowsAndEachIsCounted) {
  const int extra = GetParam();
  const auto pictures = frames_of(four_steps);
  const std::size_t count = 400, waiting = 16;
  EngineSetup scan = scan_of(four_steps);
  scan.sequence.motion = extra;
  std::promise<void> release;
  std::promise<const LivePipeline*> made;
  const LivePipeline* running = nullptr;
  auto source = std::make_unique<ScriptedSource>(pictures, in_a_row(count), true);
  source->before_step = [&](std::size_t step) {
    if (step == 0) running = made.get_future().get();
    if (step == count - 40) release.set_value();
    while (running->statistics().stages[1].waiting > waiting - 2) {
      std::this_thread::sleep_for(100us);
    }
  };
  int broken = 0;
  std::vector<std::uint64_t> newest;
  LivePipeline pipeline(std::move(source), scan,
                        {.indexing = PatternIndexing::counted,
                         .waiting_frames = waiting,
                         .on_cloud = [&](const Pooled<LiveCloud>& cloud) {
                           if (newest.size() == 10) release.get_future().wait();
                           newest.push_back(cloud->newest.sequence);
                           for (std::size_t n = 0; n < cloud->frames.size(); ++n) {
                             const auto back = cloud->frames.size() - 1 - n;
                             const std::uint64_t sequence = cloud->frames[n]->stamp.sequence;
                             const bool whole =
                                 extra > 0 ? sequence + back == cloud->newest.sequence
                                           : sequence % 4 == n && sequence + 4 > newest.back();
                             broken += whole ? 0 : 1;
                           }
                         }});
  pipeline.start();
  made.set_value(&pipeline);
  wait_for_end(pipeline);
  const LiveStatistics statistics = pipeline.statistics();
  EXPECT_EQ(statistics.frames.captured, count);
  EXPECT_EQ(statistics.frames.lost + statistics.frames.overwritten, 0U);
  EXPECT_EQ(statistics.windows_lost, 0U);
  EXPECT_GT(statistics.windows_skipped, 300U);
  EXPECT_EQ(statistics.clouds, newest.size());
  EXPECT_EQ(statistics.clouds + statistics.windows_skipped,
            count - 3 - static_cast<std::size_t>(extra));
  EXPECT_EQ(broken, 0);
  EXPECT_TRUE(std::is_sorted(newest.begin(), newest.end()));
}

INSTANTIATE_TEST_SUITE_P(LivePipeline, SlowConsumer, testing::Values(0, 2));

TEST(SlowConsumers, StopsWhileAConsumerHoldsEveryCloud) {
  std::vector<Pooled<LiveCloud>> held;
  LivePipeline pipeline(
      std::make_unique<ScriptedSource>(frames_of(four_steps), in_a_row(1000)), scan_of(four_steps),
      {.indexing = PatternIndexing::counted,
       .on_cloud = [&](const Pooled<LiveCloud>& cloud) { held.push_back(cloud); }});
  pipeline.start();
  std::this_thread::sleep_for(20ms);
  pipeline.stop();
  EXPECT_FALSE(pipeline.running());
  EXPECT_LT(held.size(), 20U);
}

TEST(SlowConsumers, ASourceWithoutPaceWaitsForSlowConsumers) {
  const auto pictures = frames_of(four_steps);
  int clouds = 0;
  LivePipeline pipeline(
      std::make_unique<ScriptedSource>(pictures, in_a_row(100)), scan_of(four_steps),
      {.indexing = PatternIndexing::counted, .on_cloud = [&](const Pooled<LiveCloud>&) {
         ++clouds;
         std::this_thread::sleep_for(1ms);
       }});
  run_to_its_end(pipeline);
  EXPECT_EQ(clouds, 97);
  EXPECT_EQ(pipeline.statistics().frames.overwritten, 0U);
}

}  // namespace slipstream::slow_consumer_test
