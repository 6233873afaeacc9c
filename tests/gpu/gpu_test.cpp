// The GPU gives the points of the equations and leaves out the same pixels, as the fused pass does;
// on whatever device there is, which is Mesa's software where there is no other.
#include "reconstruct/gpu.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <numbers>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "decode/phase_decoder.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/gpu/gpu_engine.h"
#include "response/correction.h"
#include "slipstream/engine.h"
#include "tests/every_strategy.h"
#include "tests/geometry/random_scanner.h"
#include "tests/own_strategies.h"
#include "tests/reconstruct/agreement.h"

namespace slipstream::gpu_test {

class GpuOnGpu : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_FALSE(gpu_devices().empty()) << "mesa-vulkan-drivers is not installed";
  }
};

struct Results {
  Cloud cloud;
  Maps maps;
  Image<std::uint16_t> numbers;
};

/// Whether a limit is met to rounding at the pixel or beside it: where the phases of few grey
/// levels are fractions, half a period of doubt and half a fringe between neighbours occur exactly.
bool is_at_a_limit(const BasicMaps<double>& maps, const FringeOrderConsensus& consensus,
                   double half_fringe, int column, int row) {
  constexpr double rounding = 2e-6;
  const auto near = [](double value, double limit) { return std::abs(value - limit) < rounding; };
  const Size size = maps.coordinate.size();
  bool found = false;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, size.height - 1); ++r) {
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, size.width - 1); ++c) {
      const double doubt = maps.fringe_order_doubt(c, r);
      const double apart = std::abs(maps.coordinate(c, r) - maps.coordinate(column, row));
      found = found || near(doubt, 0.5) || near(doubt, consensus.largest_doubt) ||
              near(apart, half_fringe);
    }
  }
  return found;
}

TEST_F(GpuOnGpu, LeavesOutTheSamePixelsForTheSameReasons) {
  const Scanner scanner = example_scanner({320, 240});
  const DualFrequency strategy;
  const FrameSet frames =
      statue_frames(scanner, strategy, Axis::x, {.ambient = 70, .noise_variance = 30});
  for (const ReconstructSettings& settings :
       {ReconstructSettings{}, ReconstructSettings{.minimum_modulation = 3},
        ReconstructSettings{.drop_saturated = false},
        ReconstructSettings{.minimum_modulation = 5,
        .fringe_order = {.largest_doubt = 0.1, .fewest_neighbours = 4, .fewest_if_doubtful = 8}},
        ReconstructSettings{.nearest = 560, .farthest = 600}}) {
    const EngineSetup setup = setup_of(scanner, strategy, Axis::x, settings);
    const auto gpu = GpuEngine::make(FusedEngine::make(setup, {}).value(), std::nullopt);
    Cloud cloud;
    GpuScanMemory memory;
    gpu.value()(frames, {.cloud = &cloud}, memory);
    const ReferenceResult exact = by_equations(setup, frames);
    int differing = 0, at_a_limit = 0;
    for (int row = 0; row < 240; ++row) {
      for (int column = 0; column < 320; ++column) {
        if (cloud.validity(column, row) == exact.cloud.validity(column, row)) continue;
        const bool met =
            is_at_a_limit(exact.maps, settings.fringe_order, 0.5 / strategy.high, column, row);
        (met ? at_a_limit : differing) += 1;
      }
    }
    std::cout << differing << " pixels differ, and " << at_a_limit << " at a limit\n";
    EXPECT_GT(point_count(cloud), 1000U);
    EXPECT_LE(differing, 0);
    EXPECT_LE(at_a_limit, 50);
  }
}

TEST_F(GpuOnGpu, GivesDepthAlone) {
  const Scanner scanner = example_scanner({171, 90});
  const Strategy strategy = DualFrequency{};
  EngineSetup setup = setup_of(scanner, strategy, Axis::x);
  setup.settings.engine = EngineKind::gpu;
  Engine engine(setup);
  const FrameSet frames = statue_frames(scanner, strategy, Axis::x);
  EXPECT_EQ(engine.backend_for(frames), "gpu");
  Cloud cloud;
  Depth depth;
  const FrameSet larger(
      FrameSet::Images8(static_cast<std::size_t>(frames.count()), Image<std::uint8_t>({640, 480})));
  EXPECT_THROW(engine.cloud(larger, cloud), Error);
  EXPECT_THROW(engine.cloud(frames.views().part(0, 2), cloud), Error);
  engine.cloud(frames, cloud);
  engine.depth(frames, depth);
  EXPECT_TRUE(std::equal(cloud.validity.begin(), cloud.validity.end(), depth.validity.begin()));
  const DepthScale scale{.scale = 0.02F, .offset = 100};
  Image<std::uint16_t> numbers;
  engine.depth(frames, scale, numbers);
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    if (cloud.validity.begin()[i] != Validity::valid) {
      ASSERT_EQ(numbers.begin()[i], 0);
      continue;
    }
    const float z = cloud.z.begin()[i];
    ASSERT_EQ(z, depth.z.begin()[i]);
    ASSERT_NEAR(numbers.begin()[i], (z - scale.offset) / scale.scale, 0.51);
  }
  // What 16 bits cannot tell is no point.
  for (const float offset : {0.0F, 2000.0F}) {
    engine.depth(frames, {.scale = 0.001F, .offset = offset}, numbers);
    EXPECT_TRUE(std::all_of(numbers.begin(), numbers.end(), [](auto n) { return n == 0; }));
  }
}

template <class Pixel>
bool same_bytes(const Image<Pixel>& a, const Image<Pixel>& b) {
  return a.size() == b.size() &&
         std::memcmp(a.begin(), b.begin(), a.pixel_count() * sizeof(Pixel)) == 0;
}

/// Wherever a picture is cut, the results are to the bit those of the whole.
TEST_F(GpuOnGpu, CutsLargePictures) {
  const Scanner scanner = example_scanner({171, 91});
  Image<float> coarse(scanner.camera.size);
  for (int i = 0; i < 171 * 91; ++i) coarse.begin()[i] = static_cast<float>(i % 171) / 171;
  for (const Strategy& strategy :
       {Strategy(DualFrequency{}), Strategy(PhaseChannelMultiplexing{.steps = 5}),
        Strategy(PhaseMeasuring{.frequency = 4})}) {
    const EngineSetup setup =
        setup_of(scanner, strategy, Axis::x, {.nearest = 490, .farthest = 610});
    const auto fused = FusedEngine::make(setup, {}).value();
    const Image<float>* const given = fused.wants_coarse() ? &coarse : nullptr;
    const FrameSet frames = statue_frames(scanner, strategy, Axis::x,
                                          {.noise_variance = 9, .bits = given != nullptr ? 8 : 12});
    const auto results_of = [&](std::size_t pixels) {
      const auto gpu = GpuEngine::make(fused, std::nullopt, pixels).value();
      GpuScanMemory memory;
      Results results;
      gpu(frames, {.cloud = &results.cloud, .maps = &results.maps}, memory, given);
      gpu(frames, {.depth16 = &results.numbers}, memory, given);
      return results;
    };
    const Results whole = results_of(GpuEngine::pixels_at_once);
    EXPECT_GT(point_count(whole.cloud), 1000U);
    for (const std::size_t pixels : {171 * 9, 171 * 46}) {
      const Results cut = results_of(pixels);
      EXPECT_TRUE(same_bytes(cut.cloud.x, whole.cloud.x));
      EXPECT_TRUE(same_bytes(cut.cloud.z, whole.cloud.z));
      EXPECT_TRUE(same_bytes(cut.cloud.intensity, whole.cloud.intensity));
      EXPECT_TRUE(same_bytes(cut.cloud.validity, whole.cloud.validity));
      EXPECT_TRUE(same_bytes(cut.maps.coordinate, whole.maps.coordinate));
      EXPECT_TRUE(same_bytes(cut.maps.fringe_order_doubt, whole.maps.fringe_order_doubt));
      EXPECT_TRUE(same_bytes(cut.numbers, whole.numbers));
    }
  }
}

/// So are those of scans that one submission computes.
TEST_F(GpuOnGpu, TakesManySmallScansAtOnce) {
  const Scanner scanner = example_scanner({67, 49});
  const Strategy strategy = DualFrequency{};
  const auto fused = FusedEngine::make(setup_of(scanner, strategy, Axis::x), {}).value();
  for (const int bits : {8, 12}) {
    std::vector<FrameSet> frames;
    std::vector<FrameViews> views;
    for (const double ambient : {0, 5, 10, 20, 30}) {
      frames.push_back(
          statue_frames(scanner, strategy, Axis::x, {.ambient = ambient, .bits = bits}));
      views.emplace_back(frames.back());
    }
    // Two at a time, and the last one alone; then all five.
    for (const std::size_t pixels : {std::size_t{2 * 67 * 50}, GpuEngine::pixels_at_once}) {
      const auto gpu = GpuEngine::make(fused, std::nullopt, pixels).value();
      std::vector<Results> together(views.size());
      std::vector<Outputs> clouds, depths;
      for (std::size_t i = 0; i < views.size(); ++i) {
        clouds.push_back({.cloud = &together[i].cloud, .maps = &together[i].maps});
        depths.push_back(
            {.depth16 = &together[i].numbers, .scale = {.scale = 0.02F, .offset = 100}});
      }
      GpuScanMemory memory, memory_of_one;
      gpu(views, clouds, memory);
      gpu(views, depths, memory);
      for (std::size_t i = 0; i < views.size(); ++i) {
        Results alone;
        gpu(views[i], {.cloud = &alone.cloud, .maps = &alone.maps}, memory_of_one);
        gpu(views[i], {.depth16 = &alone.numbers, .scale = depths[i].scale}, memory_of_one);
        EXPECT_GT(point_count(alone.cloud), 100U);
        EXPECT_TRUE(same_bytes(together[i].cloud.x, alone.cloud.x));
        EXPECT_TRUE(same_bytes(together[i].cloud.z, alone.cloud.z));
        EXPECT_TRUE(same_bytes(together[i].cloud.intensity, alone.cloud.intensity));
        EXPECT_TRUE(same_bytes(together[i].cloud.validity, alone.cloud.validity));
        EXPECT_TRUE(same_bytes(together[i].maps.coordinate, alone.maps.coordinate));
        EXPECT_TRUE(same_bytes(together[i].numbers, alone.numbers));
      }
    }
  }
}

/// Where the picture gives the order, the coordinate so found is handed to the device.
TEST_F(GpuOnGpu, TakesOrdersOfThePicture) {
  const Scanner scanner = example_scanner({320, 240});
  const Strategy strategy = PhaseMeasuring{.frequency = 4};
  const FrameSet frames =
      take_scan(scanner, scene_named("board", scanner), pattern_set(strategy, Axis::x), {}).frames;
  Cloud clouds[2];
  for (const EngineKind kind : {EngineKind::fused, EngineKind::gpu}) {
    Engine engine(scanner, {.strategy = strategy},
                  {.engine = kind, .nearest = 490, .farthest = 610});
    EXPECT_EQ(engine.backend_for(frames), kind == EngineKind::gpu ? "gpu" : "fused");
    engine.cloud(frames, clouds[kind == EngineKind::gpu]);
  }
  EXPECT_GT(point_count(clouds[1]), 10000U);
  for (std::size_t i = 0; i < clouds[0].z.pixel_count(); ++i) {
    ASSERT_EQ(clouds[0].validity.begin()[i], clouds[1].validity.begin()[i]);
    if (clouds[0].validity.begin()[i] != Validity::valid) continue;
    ASSERT_NEAR(clouds[0].z.begin()[i], clouds[1].z.begin()[i], 0.01);
  }
}

TEST_F(GpuOnGpu, LetsPixelsWithoutACoordinateNotConfirmEachOther) {
  const Scanner scanner = example_scanner({67, 49});
  const Strategy strategy = PhaseMeasuring{.frequency = 4};
  const EngineSetup setup = setup_of(scanner, strategy, Axis::x, {.nearest = 490, .farthest = 610});
  const FrameSet frames = statue_frames(scanner, strategy, Axis::x);
  const Image<float> coarse(scanner.camera.size, std::nanf(""));
  const auto fused = FusedEngine::make(setup, {}).value();
  const auto gpu = GpuEngine::make(fused, std::nullopt).value();

  Cloud expected, cloud;
  FusedMemory memory;
  fused(frames, {.cloud = &expected}, memory, &coarse);
  GpuScanMemory gpu_memory;
  gpu(frames, {.cloud = &cloud}, gpu_memory, &coarse);

  EXPECT_EQ(point_count(expected), 0U);
  EXPECT_TRUE(std::ranges::equal(cloud.validity, expected.validity));
}

/// A device that is lost costs no cloud: the processor makes the same points from then on, and a
/// new engine has the device again.
TEST_F(GpuOnGpu, GoesOnWithoutADeviceThatIsLost) {
  const Scanner scanner = example_scanner({171, 90});
  const Strategy strategy = DualFrequency{};
  EngineSetup setup = setup_of(scanner, strategy, Axis::x);
  setup.settings.engine = EngineKind::gpu;
  const FrameSet frames = statue_frames(scanner, strategy, Axis::x);
  Engine engine(setup), copy(engine);
  Cloud before, after;
  engine.cloud(frames, before);
  Gpu::open(std::nullopt)->lose();
  engine.cloud(frames, after);
  EXPECT_EQ(engine.backend_for(frames), "fused");
  copy.cloud(frames, after);
  EXPECT_EQ(copy.backend_for(frames), "fused");
  EXPECT_GT(point_count(after), 2000U);
  EXPECT_TRUE(std::equal(before.validity.begin(), before.validity.end(), after.validity.begin()));
  Engine again(setup);
  again.cloud(frames, after);
  EXPECT_EQ(again.backend_for(frames), "gpu");
}

TEST_F(GpuOnGpu, IsSharedByThreads) {
  const Scanner scanner = example_scanner({171, 90});
  const Strategy strategy = DualFrequency{};
  EngineSetup setup = setup_of(scanner, strategy, Axis::x);
  setup.settings.engine = EngineKind::gpu;
  const FrameSet frames = statue_frames(scanner, strategy, Axis::x);
  Engine engine(setup);
  Cloud expected;
  engine.cloud(frames, expected);
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, copy = Engine(engine)]() mutable {
      Cloud cloud;
      for (int run = 0; run < 20; ++run) {
        copy.cloud(frames, cloud);
        ASSERT_TRUE(
            std::equal(cloud.validity.begin(), cloud.validity.end(), expected.validity.begin()));
      }
      EXPECT_EQ(copy.backend_for(frames), "gpu");
    });
  }
}

/// Of the process, bytes that are in memory.
std::size_t resident() {
  std::size_t all = 0, pages = 0;
  std::ifstream("/proc/self/statm") >> all >> pages;
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

/// SLIPSTREAM_GPU_SCANS: how many, where not a thousand.
TEST_F(GpuOnGpu, KeepsItsMemoryFlat) {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "no such memory under the sanitizers";
#endif
  const Scanner scanner = example_scanner({64, 48});
  const Strategy strategy = DualFrequency{};
  EngineSetup setup = setup_of(scanner, strategy, Axis::x);
  setup.settings.engine = EngineKind::gpu;
  const FrameSet frames = statue_frames(scanner, strategy, Axis::x);
  Engine engine(setup);
  Cloud cloud;
  const char* const asked = std::getenv("SLIPSTREAM_GPU_SCANS");
  const long scans = asked != nullptr ? std::atol(asked) : 1000;
  std::size_t before = 0;
  for (long scan = 0; scan < scans; ++scan) {
    engine.cloud(frames, cloud);
    if (scan == scans / 2) before = resident();
  }
  EXPECT_EQ(engine.backend_for(frames), "gpu");
  EXPECT_LE(resident(), before + (std::size_t{4} << 20));
  std::cout << scans << " scans, " << resident() / 1024 << " KiB resident, " << before / 1024
            << " half way\n";
}

TEST_F(GpuOnGpu, RefusesADeviceThatIsNotThere) {
  const Scanner scanner = example_scanner({64, 48});
  EXPECT_THROW(
      Engine(scanner, {.strategy = DualFrequency{}}, {.engine = EngineKind::gpu, .gpu = 99}),
      WorldError);
}

}  // namespace slipstream::gpu_test
