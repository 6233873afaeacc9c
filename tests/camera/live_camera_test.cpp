// The whole way from UDP packets to clouds.
#include <atomic>
#include <chrono>
#include <cstring>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/camera/genicam.h"
#include "slipstream/camera/virtual_gige_camera.h"
#include "slipstream/error/error.h"
#include "slipstream/live/live_pipeline.h"
#include "slipstream/reconstruct/engine.h"
#include "slipstream/simulate/named_scenes.h"
#include "slipstream/strategy/phase_measuring.h"
#include "tests/live/virtual_loop.h"

namespace slipstream {
namespace {
using namespace std::chrono_literals;
using std::chrono::steady_clock;

constexpr int cycles = 3;
constexpr Size size{320, 240};

std::unique_ptr<VirtualGigeCamera> serve(const std::vector<Frame>& loop) {
  try {
    return std::make_unique<VirtualGigeCamera>(loop, "127.0.0.1", "LIVE");
  } catch (const WorldError&) {
    return nullptr;
  }
}

bool same_bits(const Image<float>& one, const Image<float>& other) {
  return one.size() == other.size() &&
         std::memcmp(one.begin(), other.begin(), one.pixel_count() * sizeof(float)) == 0;
}

/// A moving scene's frames, and the cloud of each window of them, reconstructed beforehand.
struct Offline {
  EngineSetup setup{.scanner = example_scanner(size),
                    .sequence = {.strategy = PhaseMeasuring{.steps = 4, .frequency = 1}}};
  std::vector<Frame> loop =
      frames_of(setup.sequence.strategy,
                {.size = size, .motion = Eigen::Vector3d(1, 0, 0.5), .cycles = cycles});
  std::vector<Cloud> clouds;  ///< of the window that ends with that frame of the loop

  Offline() {
    Engine engine(setup);
    const int count = static_cast<int>(loop.size());
    for (int newest = 0; newest < count; ++newest) {
      Frames<std::uint8_t> window(4);
      for (int age = 0; age < 4; ++age) {
        const int at = (newest - age + count) % count;
        window[static_cast<std::size_t>(at % 4)] =
            std::get<0>(loop[static_cast<std::size_t>(at)].pixels);
      }
      clouds.emplace_back();
      engine.cloud(window, clouds.back());
    }
  }

  [[nodiscard]] bool has(const LiveCloud& live) const {
    const Cloud& cloud = clouds[live.newest.sequence % clouds.size()];
    return same_bits(live.cloud.x, cloud.x) && same_bits(live.cloud.y, cloud.y) &&
           same_bits(live.cloud.z, cloud.z) && same_bits(live.cloud.intensity, cloud.intensity);
  }
};

CameraSettings settings_for(const Offline& offline) {
  return {.frame_rate = 100, .packet_size = 8000, .cycle = static_cast<int>(offline.loop.size())};
}

TEST(LiveCamera, EachFrameGivesTheCloudOfTheOfflineScan) {
  const Offline offline;
  const auto camera = serve(offline.loop);
  if (!camera) GTEST_SKIP() << "no camera can be served at 127.0.0.1";
  std::uint64_t clouds = 0, wrong = 0;
  LivePipeline pipeline(open_genicam_camera("127.0.0.1", settings_for(offline)), offline.setup,
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
  EXPECT_EQ(statistics.frames.lost, 0U);
  EXPECT_EQ(wrong, 0U);
  if (statistics.frames.overwritten == 0) {
    EXPECT_EQ(clouds, 197U) << "one for each but the first three";
  }
}

TEST(LiveCamera, CloudsGoOnWhenTheCameraIsBackAndMixNothing) {
  const Offline offline;
  auto camera = serve(offline.loop);
  if (!camera) GTEST_SKIP() << "no camera can be served at 127.0.0.1";
  std::atomic<std::uint64_t> clouds = 0, wrong = 0;
  LivePipeline pipeline(
      open_genicam_camera("127.0.0.1", settings_for(offline)), offline.setup,
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

}  // namespace
}  // namespace slipstream
