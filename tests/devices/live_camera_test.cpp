// From UDP packets to clouds.
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "devices/genicam.h"
#include "io/recorder.h"
#include "slipstream/live_pipeline.h"
#include "slipstream/recording.h"
#include "tests/devices/offline.h"
#include "tests/devices/served_camera.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::live_camera_test {
using namespace std::chrono_literals;
using std::chrono::steady_clock;

TEST(LiveCamera, EachFrameGivesTheCloudOfTheOfflineScan) {
  const Offline offline;
  const auto camera = serve(offline.loop);
  REQUIRE_CAMERA(camera);
  std::uint64_t clouds = 0, wrong = 0;
  LivePipeline pipeline(open_genicam_camera(served_address, settings_for(offline)), offline.setup,
                        {.indexing = PatternIndexing::counted,
                         .most_frames = 200,
                         .on_cloud = [&](const Pooled<LiveCloud>& cloud) {
                           ++clouds;
                           if (!offline.has(*cloud)) ++wrong;
                         }});
  pipeline.start();
  for (const auto end = steady_clock::now() + 20s;
       pipeline.running() && steady_clock::now() < end;) {
    std::this_thread::sleep_for(10ms);
  }
  pipeline.stop();
  const LiveStatistics statistics = pipeline.statistics();
  EXPECT_EQ(statistics.frames.captured, 200U);
  EXPECT_EQ(wrong, 0U);
  EXPECT_EQ(clouds, statistics.clouds);
  EXPECT_GT(clouds, 50U);

  // Each frame but the first three ends a window; on a busy machine some give no cloud.
  EXPECT_EQ(statistics.clouds + statistics.windows_lost + statistics.windows_skipped,
            statistics.frames.captured + statistics.frames.lost - 3);
}

TEST(LiveCamera, CloudsGoOnWhenTheCameraIsBackAndMixNothing) {
  const Offline offline;
  auto camera = serve(offline.loop);
  REQUIRE_CAMERA(camera);
  std::atomic<std::uint64_t> clouds = 0, wrong = 0;
  LivePipeline pipeline(
      open_genicam_camera(served_address, settings_for(offline)), offline.setup,
      {.indexing = PatternIndexing::counted, .on_cloud = [&](const Pooled<LiveCloud>& cloud) {
         ++clouds;
         if (!offline.has(*cloud)) ++wrong;
       }});
  pipeline.start();
  const auto wait_for = [&](const auto& condition) {
    const auto end = steady_clock::now() + 20s;
    while (!condition() && steady_clock::now() < end) std::this_thread::sleep_for(5ms);
    return condition();
  };
  ASSERT_TRUE(wait_for([&] { return clouds > 30; }));
  camera.reset();
  ASSERT_TRUE(wait_for([&] { return !pipeline.statistics().source_state.empty(); }));
  const std::uint64_t before = clouds;
  camera = serve(offline.loop);
  ASSERT_TRUE(camera);
  ASSERT_TRUE(wait_for([&] { return clouds > before + 30; }));
  EXPECT_EQ(pipeline.statistics().source_state, "");
  pipeline.stop();
  EXPECT_EQ(wrong, 0U);
}

TEST(LiveCamera, ARecordingKeepsTheTemperaturesOfItsStart) {
  const Offline offline;
  const auto camera = serve(offline.loop);
  REQUIRE_CAMERA(camera);
  RecordedSource source(open_genicam_camera(served_address, settings_for(offline)),
                        {.sequence = offline.setup.sequence});

  const TemporaryFolder folder;
  source.record_to(folder.path() / "scan.slip");
  source.start();
  Frame frame(source.format());
  ASSERT_EQ(source.next(frame, 10s), Arrival::frame);
  source.stop();
  source.finish_recording();
  EXPECT_EQ(RecordingReader(folder.path() / "scan.slip").header().temperatures,
            (Temperatures{{"Mainboard", 38}, {"Sensor", 41}}));
}

}  // namespace slipstream::live_camera_test
