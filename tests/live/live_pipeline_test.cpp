#include "slipstream/live_pipeline.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <future>
#include <map>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

#include "reconstruct/pipeline.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "tests/live/scripted_source.h"
#include "tests/live/virtual_loop.h"

namespace slipstream::live_pipeline_test {
using namespace std::chrono_literals;

const Strategy four_steps = PhaseMeasuring{.steps = 4, .frequency = 1};

template <class Pixel>
bool same_bytes(const Image<Pixel>& a, const Image<Pixel>& b) {
  return a.size() == b.size() &&
         std::memcmp(a.begin(), b.begin(), a.pixel_count() * sizeof(Pixel)) == 0;
}

bool same_bytes(const Cloud& a, const Cloud& b) {
  return same_bytes(a.x, b.x) && same_bytes(a.y, b.y) && same_bytes(a.z, b.z) &&
         same_bytes(a.intensity, b.intensity) && same_bytes(a.validity, b.validity);
}

FrameSet set_of(const std::vector<Frame>& pictures, const std::vector<int>& indices) {
  const auto copies = [&]<class Pixel>(Pixel) {
    std::vector<Image<Pixel>> images;
    for (const int i : indices) {
      const Frame& picture = pictures[static_cast<std::size_t>(i) % pictures.size()];
      images.push_back(std::get<Image<Pixel>>(picture.pixels));
    }
    return images;
  };
  const int bits = pictures.front().bits;
  if (bits == 8) return FrameSet(copies(std::uint8_t()));
  return {copies(std::uint16_t()), bits};
}

/// Counts the clouds that equal, byte for byte, an offline reconstruction of the same pictures.
class OfflineCheck {
 public:
  OfflineCheck(const EngineSetup& scan, const std::vector<Frame>& pictures,
               const std::vector<ScriptedStep>& script)
      : reconstruct_(scan), steps_(frame_count(scan.sequence.strategy)), pictures_(pictures) {
    for (const ScriptedStep& step : script) {
      if (step.arrival == Arrival::frame) shown_[step.sequence] = step.frame;
    }
  }

  void operator()(const LiveCloud& live) {
    std::vector<int> indices;
    for (const auto& frame : live.frames) indices.push_back(shown_.at(frame->stamp.sequence));
    bool in_order = static_cast<int>(indices.size()) == steps_;
    for (int n = 0; n < steps_; ++n) {
      in_order = in_order && indices[static_cast<std::size_t>(n)] % steps_ == n;
    }
    Cloud offline;
    reconstruct_.cloud(set_of(pictures_, indices), offline);
    const bool whole = in_order && same_bytes(live.cloud, offline);
    ++(whole ? equal : other);
    newest.push_back(live.newest.sequence);
  }

  int equal = 0, other = 0;
  std::vector<std::uint64_t> newest;

 private:
  Engine reconstruct_;
  int steps_;
  const std::vector<Frame>& pictures_;
  std::map<std::uint64_t, int> shown_;
};

/// Result of a script run to its end, with every cloud checked.
struct Ran {
  int equal = 0, other = 0;
  std::vector<std::uint64_t> newest;
  LiveStatistics statistics;
};

Ran run(const Strategy& strategy, const std::vector<Frame>& pictures,
        const std::vector<ScriptedStep>& script, LiveSettings settings = {}) {
  const EngineSetup scan = scan_of(strategy, pictures.front().format().size);
  OfflineCheck check(scan, pictures, script);
  settings.on_cloud = [&](const Pooled<LiveCloud>& cloud) { check(*cloud); };
  LivePipeline pipeline(std::make_unique<ScriptedSource>(pictures, script), scan, settings);
  run_to_its_end(pipeline);
  EXPECT_EQ(pipeline.failure(), nullptr);
  return {check.equal, check.other, check.newest, pipeline.statistics()};
}

TEST(LivePipeline, EachFrameGivesTheCloudThatItsWindowGivesByItself) {
  for (const Strategy& strategy :
       {Strategy(PhaseMeasuring{.steps = 3, .frequency = 1}), four_steps,
        Strategy(PhaseMeasuring{.steps = 6, .frequency = 1}), Strategy(DualFrequency{.steps = 3}),
        Strategy(PhaseChannelMultiplexing{.steps = 5})}) {
    for (const int bits : {8, 12}) {
      SCOPED_TRACE(strategy.name() + " " + std::to_string(bits));
      const int N = frame_count(strategy);
      const auto pictures =
          frames_of(strategy, {.motion = {0.5, 0, 0},
                               .photometry = {.ambient = 5, .noise_variance = 1.5, .bits = bits}});
      const Ran ran =
          run(strategy, pictures, in_a_row(10 * N), {.indexing = PatternIndexing::counted});
      EXPECT_EQ(ran.equal, 9 * N + 1);
      EXPECT_EQ(ran.other, 0);
      EXPECT_TRUE(std::is_sorted(ran.newest.begin(), ran.newest.end()));
      EXPECT_EQ(ran.statistics.frames.captured, static_cast<std::uint64_t>(10 * N));
      EXPECT_EQ(ran.statistics.frames.lost, 0U);
      EXPECT_EQ(ran.statistics.clouds, static_cast<std::uint64_t>(9 * N + 1));
      EXPECT_EQ(ran.statistics.windows_lost, 0U);
    }
  }
}

TEST(LivePipeline, WithoutAFusedPassCloudsAreThoseInDouble) {
  const Size size{12, 16};
  EngineSetup scan = scan_of(four_steps, size);
  scan.settings.clean = CleanSettings::none();
  const auto pictures = frames_of(four_steps, {.size = size});
  const BasicCloud<double> offline =
      ReferenceEngine(scan, {})(set_of(pictures, {0, 1, 2, 3})).cloud;
  std::vector<float> z;
  LivePipeline pipeline(
      std::make_unique<ScriptedSource>(pictures, in_a_row(4)), scan,
      {.indexing = PatternIndexing::counted, .on_cloud = [&](const Pooled<LiveCloud>& cloud) {
         z.assign(cloud->cloud.z.begin(), cloud->cloud.z.end());
       }});
  run_to_its_end(pipeline);
  ASSERT_EQ(z.size(), offline.z.pixel_count());
  for (std::size_t i = 0; i < z.size(); ++i) {
    const auto expected = static_cast<float>(offline.z.begin()[i]);
    EXPECT_EQ(std::memcmp(&z[i], &expected, sizeof(float)), 0);
  }
}

TEST(LivePipeline, LostDamagedAndWrongFramesCostTheirWindowsAlone) {
  auto pictures = frames_of(four_steps);
  pictures.resize(4);
  auto script = in_a_row(60);
  // Each costs four windows.
  script[10].arrival = Arrival::damaged;
  script.erase(script.begin() + 20);
  pictures.push_back(Frame({{32, 16}, 8}));
  for (ScriptedStep& step : script) step.frame %= 4;
  const auto wrong_size =
      std::find_if(script.begin(), script.end(), [](const auto& s) { return s.sequence == 30; });
  wrong_size->frame = 4;
  const Ran ran = run(four_steps, pictures, script, {.indexing = PatternIndexing::counted});
  EXPECT_EQ(ran.other, 0);
  EXPECT_EQ(ran.equal, 57 - 12);
  EXPECT_EQ(ran.statistics.frames.captured, 57U);
  EXPECT_EQ(ran.statistics.frames.lost, 3U);
  EXPECT_EQ(ran.statistics.windows_lost, 12U);
  EXPECT_EQ(ran.statistics.resynchronisations, 0U);
}

TEST(LivePipeline, RepeatedAndReorderedFramesCostNothing) {
  auto script = in_a_row(40);
  script.insert(script.begin() + 15, script[14]);
  script.insert(script.begin() + 20, script[17]);
  std::swap(script[30], script[31]);
  const Ran ran =
      run(four_steps, frames_of(four_steps), script, {.indexing = PatternIndexing::counted});
  EXPECT_EQ(ran.other, 0);
  EXPECT_EQ(ran.equal, 37);
  EXPECT_EQ(ran.statistics.frames.captured, 40U);
  EXPECT_EQ(ran.statistics.frames.repeated, 2U);
  EXPECT_EQ(ran.statistics.frames.lost, 0U);
  EXPECT_EQ(ran.statistics.windows_lost, 0U);
}

TEST(LivePipeline, SlippedIndicesAreSetRightAndNoCloudIsWrong) {
  for (const Strategy& strategy : {Strategy(PhaseMeasuring{.steps = 3, .frequency = 1}), four_steps,
                                   Strategy(PhaseMeasuring{.steps = 6, .frequency = 1}),
                                   Strategy(DualFrequency{.steps = 3})}) {
    const int N = frame_count(strategy);
    auto script = in_a_row(10 * N);
    for (std::size_t n = static_cast<std::size_t>(4 * N + 1); n < script.size(); ++n) {
      ++script[n].frame;
    }
    const Ran ran =
        run(strategy, frames_of(strategy), script, {.indexing = PatternIndexing::counted});
    EXPECT_EQ(ran.other, 0);
    EXPECT_EQ(ran.equal, 9 * N + 1 - (N - 1));
    EXPECT_EQ(ran.statistics.resynchronisations, 1U);
    EXPECT_EQ(ran.statistics.windows_lost, static_cast<std::uint64_t>(N - 1));
  }
}

TEST(LivePipeline, ResumesWhenTheSourceIsBack) {
  auto script = in_a_row(20);
  script.insert(script.begin() + 10, 5,
                {.arrival = Arrival::nothing, .state = "the camera is gone; looking for it"});
  const auto pictures = frames_of(four_steps);
  const EngineSetup scan = scan_of(four_steps);
  OfflineCheck check(scan, pictures, script);
  auto source = std::make_unique<ScriptedSource>(pictures, script);
  std::promise<void> looked;
  std::promise<void> gone;
  source->before_step = [&](std::size_t step) {
    if (step != 12) return;
    gone.set_value();
    looked.get_future().wait();
  };
  LivePipeline pipeline(std::move(source), scan,
                        {.indexing = PatternIndexing::counted,
                         .on_cloud = [&](const Pooled<LiveCloud>& cloud) { check(*cloud); }});
  pipeline.start();
  gone.get_future().wait();
  EXPECT_EQ(pipeline.statistics().source_state, "the camera is gone; looking for it");
  EXPECT_TRUE(pipeline.running());
  looked.set_value();
  wait_for_end(pipeline);
  EXPECT_EQ(check.equal, 17);
  EXPECT_EQ(check.other, 0);
  EXPECT_EQ(pipeline.statistics().source_state, "");
}

TEST(LivePipeline, ACameraThatCountsAnewCostsTheWindowsAcross) {
  auto script = in_a_row(200);
  for (std::size_t n = 100; n < script.size(); ++n) script[n].sequence -= 100;
  const auto pictures = frames_of(four_steps);
  LivePipeline pipeline(std::make_unique<ScriptedSource>(pictures, script), scan_of(four_steps),
                        {.indexing = PatternIndexing::counted});
  run_to_its_end(pipeline);
  EXPECT_EQ(pipeline.statistics().frames.captured, 200U);
  EXPECT_EQ(pipeline.statistics().clouds, 194U);
  EXPECT_EQ(pipeline.statistics().windows_lost, 3U);
}

TEST(LivePipeline, ANewestCloudMayBeKept) {
  const auto pictures = frames_of(four_steps);
  LivePipeline pipeline(std::make_unique<VirtualCamera>(pictures), scan_of(four_steps));
  EXPECT_FALSE(pipeline.newest());
  pipeline.start();
  Pooled<LiveCloud> first;
  while (!first) first = pipeline.newest();
  const auto sequence = first->newest.sequence;
  const float z = first->cloud.z(32, 24);
  pipeline.shown(first->newest.host_time);
  Pooled<LiveCloud> later = pipeline.newest();
  while (later->newest.sequence < sequence + 100) later = pipeline.newest();
  EXPECT_EQ(first->newest.sequence, sequence);
  EXPECT_EQ(std::memcmp(&z, &first->cloud.z(32, 24), sizeof z), 0);
  EXPECT_GT(pipeline.statistics().screen_latency.max, 0);
  pipeline.stop();
  EXPECT_GT(pipeline.newest()->newest.sequence, sequence);
}

TEST(LivePipeline, StopsInEveryStateAndStartsAgain) {
  const auto pictures = frames_of(four_steps);
  LivePipeline pipeline(std::make_unique<VirtualCamera>(pictures), scan_of(four_steps),
                        {.most_frames = 50});
  pipeline.stop();
  EXPECT_FALSE(pipeline.running());
  EXPECT_EQ(pipeline.statistics().frames.captured, 0U);
  for (int round = 0; round < 10; ++round) {
    pipeline.start();
    if (round % 3 == 1) std::this_thread::sleep_for(1ms);
    if (round % 3 == 2) wait_for_end(pipeline);
    pipeline.stop();
    pipeline.stop();
    EXPECT_FALSE(pipeline.running());
    const LiveStatistics statistics = pipeline.statistics();
    // All captured frames are processed.
    const std::uint64_t captured = statistics.frames.captured;
    EXPECT_EQ(statistics.clouds, captured < 4 ? 0 : captured - 3);
    if (round % 3 == 2) EXPECT_EQ(captured, 50U);
  }
  pipeline.start();  // the destructor stops it
}

TEST(LivePipeline, WaitsForItsEndWhoeverBringsIt) {
  LivePipeline pipeline(std::make_unique<VirtualCamera>(frames_of(four_steps)),
                        scan_of(four_steps));
  pipeline.wait();  // it has not begun

  pipeline.start();
  std::atomic<bool> has_ended = false;
  std::thread waiting([&] {
    pipeline.wait();
    has_ended = true;
  });
  std::this_thread::sleep_for(5ms);
  EXPECT_FALSE(has_ended);
  pipeline.stop();
  waiting.join();
  EXPECT_FALSE(pipeline.running());
  pipeline.wait();
}

TEST(LivePipeline, StopsAtOnceWhileTheSourceIsSilent) {
  LivePipeline pipeline(std::make_unique<VirtualCamera>(frames_of(four_steps), 0.001),
                        scan_of(four_steps));
  pipeline.start();
  std::this_thread::sleep_for(5ms);
  EXPECT_TRUE(pipeline.running());
  pipeline.stop();
  EXPECT_EQ(pipeline.statistics().frames.captured, 0U);
}

TEST(LivePipeline, WhatAStageThrowsEndsItAndCanBeAskedFor) {
  const auto pictures = frames_of(four_steps);
  const auto message_of = [](const std::exception_ptr& failure) -> std::string {
    try {
      if (failure) std::rethrow_exception(failure);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  };
  {
    LivePipeline pipeline(std::make_unique<VirtualCamera>(pictures), scan_of(four_steps),
                          {.on_cloud = [](const Pooled<LiveCloud>&) {
                            throw std::runtime_error("the consumer has had enough");
                          }});
    run_to_its_end(pipeline);
    EXPECT_EQ(message_of(pipeline.failure()), "the consumer has had enough");
    pipeline.start();
    pipeline.stop();
  }
  auto source = std::make_unique<ScriptedSource>(pictures, in_a_row(20));
  source->before_step = [](std::size_t step) {
    if (step == 10) throw WorldError("the bus is broken");
  };
  LivePipeline pipeline(std::move(source), scan_of(four_steps));
  run_to_its_end(pipeline);
  EXPECT_EQ(message_of(pipeline.failure()), "the bus is broken");
}

TEST(LivePipeline, ScanIsChangedWhileItRuns) {
  // Dark frames, so their number does not matter.
  const auto pictures = frames_of(with_marker({.shape = {}}), {.cycles = 4});
  std::atomic<std::size_t> window = 0;
  std::atomic<std::size_t> dark = 0;
  LivePipeline pipeline(
      std::make_unique<VirtualCamera>(pictures), scan_of(four_steps),
      {.indexing = PatternIndexing::counted, .on_cloud = [&](const Pooled<LiveCloud>& cloud) {
         dark = static_cast<std::size_t>(std::count(
             cloud->cloud.validity.begin(), cloud->cloud.validity.end(), Validity::too_dark));
         window = cloud->frames.size();  // set last, so `dark` is valid once it changes
       }});
  pipeline.start();
  while (window != 4) std::this_thread::sleep_for(1ms);
  EXPECT_GT(dark, 1000U);
  EngineSetup scan = scan_of(four_steps);
  scan.settings.minimum_modulation = 0;
  pipeline.change(scan);
  while (dark != 0) std::this_thread::sleep_for(1ms);
  pipeline.change(scan_of(PhaseMeasuring{.steps = 16, .frequency = 1}));
  while (window != 16) std::this_thread::sleep_for(1ms);
  EXPECT_THROW(pipeline.change(scan_of(four_steps, {32, 24})), Error);
  pipeline.change(scan_of(DualFrequency{.steps = 3}));
  while (window != 6) std::this_thread::sleep_for(1ms);
  pipeline.stop();
  EXPECT_EQ(pipeline.failure(), nullptr);
}

TEST(LivePipeline, FramesForMotionAreAddedAndLeftOutWhileItRuns) {
  std::atomic<std::size_t> window = 0;
  LivePipeline pipeline(
      std::make_unique<VirtualCamera>(frames_of(four_steps)), scan_of(four_steps),
      {.on_cloud = [&](const Pooled<LiveCloud>& cloud) { window = cloud->frames.size(); }});
  const auto wait_for_window = [&](std::size_t frames) {
    while (window != frames && pipeline.running()) std::this_thread::sleep_for(1ms);
    EXPECT_EQ(window, frames);
  };
  pipeline.start();
  wait_for_window(4);
  EngineSetup moving = scan_of(four_steps);
  moving.sequence.motion = 2;
  pipeline.change(moving);
  wait_for_window(6);
  pipeline.change(scan_of(four_steps));
  wait_for_window(4);
  pipeline.stop();
  EXPECT_EQ(pipeline.failure(), nullptr);
}

TEST(LivePipeline, EachCloudKnowsTheSequenceOfItsFrames) {
  const EngineSetup before = scan_of(PhaseMeasuring{.steps = 6, .frequency = 1});
  const EngineSetup after = scan_of(DualFrequency{.steps = 3});  // the same number of frames
  std::atomic<bool> changed = false;
  std::atomic<int> clouds = 0, unknown = 0;
  LivePipeline pipeline(
      std::make_unique<VirtualCamera>(frames_of(before.sequence.strategy)), before,
      {.indexing = PatternIndexing::counted, .on_cloud = [&](const Pooled<LiveCloud>& cloud) {
         const Sequence& sequence = *cloud->sequence;
         if (sequence == after.sequence) changed = true;
         if (sequence != (changed ? after : before).sequence) ++unknown;
         ++clouds;
       }});
  pipeline.start();
  while (clouds == 0) std::this_thread::sleep_for(1ms);
  EXPECT_FALSE(changed);
  pipeline.change(after);
  while (!changed) std::this_thread::sleep_for(1ms);
  pipeline.stop();
  EXPECT_EQ(unknown, 0);
}

TEST(LivePipeline, RefusesWhatDoesNotFitTheFrames) {
  const auto pictures = frames_of(four_steps);
  const auto make = [&](const EngineSetup& scan, const LiveSettings& settings = {}) {
    LivePipeline(std::make_unique<VirtualCamera>(pictures), scan, settings);
  };
  EXPECT_THROW(make(scan_of(four_steps, {32, 24})), Error);
  EXPECT_THROW(make(scan_of(PhaseMeasuring{.steps = 4, .frequency = 3})), Error);
  EXPECT_THROW(make(scan_of(PhaseMeasuring{.steps = 2, .frequency = 1})), Error);

  // Frames of more than 16 GiB.
  EXPECT_THROW(make(scan_of(four_steps), {.held_clouds = std::size_t{1} << 30}), Error);
}

TEST(LivePipeline, TellsWhatItsStagesDid) {
  const auto pictures = frames_of(four_steps);
  LivePipeline pipeline(std::make_unique<VirtualCamera>(pictures), scan_of(four_steps),
                        {.most_frames = 500});
  run_to_its_end(pipeline);
  const LiveStatistics statistics = pipeline.statistics();
  ASSERT_EQ(statistics.stages.size(), 4U);
  const std::vector<std::string> names{"capture", "window", "reconstruct", "show"};
  for (std::size_t i = 0; i < 4; ++i) {
    const StageStatistics& stage = statistics.stages[i];
    EXPECT_EQ(stage.name, names[i]);
    EXPECT_EQ(stage.done, i == 0 ? 500U : 497U);
    EXPECT_EQ(stage.waiting, 0U);
    EXPECT_GT(stage.latency.p50, 0);
    EXPECT_LE(stage.latency.p50, stage.latency.p99);
    EXPECT_LE(stage.latency.p99, stage.latency.max);
  }
  EXPECT_GE(statistics.latency.p50, statistics.stages[0].latency.p50);
  EXPECT_GT(statistics.seconds, 0);
  EXPECT_NEAR(statistics.clouds_per_second, 497 / statistics.seconds, 1e-6);
}

TEST(LivePipeline, WithoutAScannerHandsOnFramesAndFindingsWithoutPoints) {
  const EngineSetup scan{.scanner = without_geometry({64, 48}, {}),
                         .sequence = {.strategy = DualFrequency{.steps = 4, .high = 16}}};
  std::vector<Frame> pictures = frames_of(scan.sequence.strategy);
  std::swap(pictures[1].pixels, pictures[2].pixels);  // in every cycle
  for (std::size_t n = 8; n < pictures.size(); ++n) pictures[n].pixels = pictures[n % 8].pixels;
  std::uint64_t handed_on = 0;
  LivePipeline pipeline(std::make_unique<VirtualCamera>(pictures), scan,
                        {.most_frames = 40, .on_cloud = [&](const Pooled<LiveCloud>& live) {
                           EXPECT_TRUE(live->cloud.z.empty());
                           EXPECT_EQ(live->frames.size(), 8U);
                           ++handed_on;
                         }});
  run_to_its_end(pipeline);
  EXPECT_EQ(pipeline.failure(), nullptr);
  EXPECT_EQ(handed_on, 33U);
  EXPECT_FALSE(pipeline.findings().empty()) << "two frames are swapped";
}

}  // namespace slipstream::live_pipeline_test
