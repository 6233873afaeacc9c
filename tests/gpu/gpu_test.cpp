// The GPU gives the points of the equations and leaves out the same pixels, as the fused pass does;
// on whatever device there is, which is Mesa's software where there is no other.
#include "slipstream/gpu/gpu.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "slipstream/gamma/correction.h"
#include "slipstream/reconstruct/detail/gpu_engine.h"
#include "slipstream/reconstruct/engine.h"
#include "tests/every_strategy.h"
#include "tests/geometry/random_scanner.h"
#include "tests/own_strategies.h"
#include "tests/reconstruct/agreement.h"

namespace slipstream {
namespace {

class OnGpu : public testing::Test {
 protected:
  void SetUp() override {
    if (gpu_devices().empty()) GTEST_SKIP() << "no device that Vulkan finds";
  }
};

Cloud cloud_of(const GpuEngine& reconstruct, const FrameViews& frames) {
  Cloud cloud;
  GpuScanMemory memory;
  reconstruct(frames, {.cloud = &cloud}, memory);
  return cloud;
}

Agreement gpu_agreement(const EngineSetup& setup, const FrameViews& frames,
                        const PhaseCorrections& corrections = {}) {
  const auto fused = FusedEngine::make(setup, corrections);
  const auto gpu = fused ? GpuEngine::make(*fused, std::nullopt) : std::nullopt;
  if (!gpu) {
    ADD_FAILURE() << "not on a GPU";
    return {};
  }
  return compare(setup.scanner, setup.sequence.axis, cloud_of(*gpu, frames),
                 by_equations(setup, frames, corrections));
}

/// Pictures whose widths are no multiples of anything, of both axes and of 8 to 16 bits.
TEST_F(OnGpu, HasThePointsOfTheEquations) {
  const Strategy strategies[] = {PhaseMeasuring{.steps = 3, .frequency = 1},
                                 PhaseMeasuring{.steps = 5, .frequency = 0.8},
                                 PhaseMeasuring{.steps = 9, .frequency = 1},
                                 DualFrequency{.steps = 4, .low_steps = 3, .high = 16, .low = 1},
                                 DualFrequency{.steps = 6, .high = 8, .low = 0.5}};
  for (const int width : {160, 171}) {
    const Scanner scanner = example_scanner({width, 91});
    for (const Axis axis : {Axis::x, Axis::y}) {
      int bits = 8;
      for (const Strategy& strategy : strategies) {
        SCOPED_TRACE(fmt::format("{}, {} bits, width {}, axis {}", name_of(strategy), bits, width,
                                 name_of(axis)));
        const FrameSet frames = statue_frames(scanner, strategy, axis,
                                              {.ambient = 5, .noise_variance = 1.55, .bits = bits});
        const Agreement agreement = gpu_agreement(setup_of(scanner, strategy, axis), frames);
        EXPECT_GT(agreement.points, 2000U);
        EXPECT_LE(agreement.other_validity, 1U);
        EXPECT_EQ(agreement.other_intensity, 0U);
        EXPECT_LE(agreement.worst, depth_bound);
        bits += 2;
      }
    }
  }
}

/// All that the shaders take, of all that the fused pass does.
TEST_F(OnGpu, HasThePointsOfTheFusedPassForEveryStrategy) {
  const Scanner scanner = example_scanner({203, 120});
  std::vector<Strategy> strategies = own_strategies();
  for (const Strategy& strategy : every_phase_strategy()) strategies.push_back(strategy);
  std::size_t taken = 0, left = 0, pixels = 0, differing = 0;
  for (const Strategy& strategy : strategies) {
    SCOPED_TRACE(label_of(strategy));
    const EngineSetup setup = setup_of(scanner, strategy, Axis::x);
    const auto fused = FusedEngine::make(setup, {});
    ASSERT_TRUE(fused);
    const auto gpu = GpuEngine::make(*fused, std::nullopt);
    (gpu ? taken : left) += 1;
    EXPECT_EQ(gpu.has_value(), !fused->stages().cue.has_value());
    if (!gpu) continue;
    const FrameSet frames = statue_frames(scanner, strategy, Axis::x);
    Cloud expected;
    Maps maps, expected_maps;
    FusedMemory memory;
    (*fused)(frames, {.cloud = &expected, .maps = &expected_maps}, memory);
    Cloud cloud;
    GpuScanMemory gpu_memory;
    (*gpu)(frames, {.cloud = &cloud, .maps = &maps}, gpu_memory);
    for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
      ++pixels;
      if (cloud.validity.begin()[i] != expected.validity.begin()[i]) {
        ++differing;
        continue;
      }
      ASSERT_NEAR(maps.mean.begin()[i], expected_maps.mean.begin()[i], 1e-3);
      ASSERT_NEAR(maps.modulation.begin()[i], expected_maps.modulation.begin()[i], 1e-3);
      if (expected.validity.begin()[i] != Validity::valid) continue;
      ASSERT_NEAR(cloud.z.begin()[i], expected.z.begin()[i], 1e-4 * expected.z.begin()[i]);
      ASSERT_NEAR(cloud.intensity.begin()[i], expected.intensity.begin()[i], 1e-3);
      ASSERT_NEAR(maps.coordinate.begin()[i], expected_maps.coordinate.begin()[i], 2e-6);
      const float apart = maps.wrapped_phase.begin()[i] - expected_maps.wrapped_phase.begin()[i];
      ASSERT_LE(std::abs(std::remainder(apart, 2 * 3.14159265F)), 4e-6F);
      if (maps.fringe_order_doubt.empty()) continue;
      ASSERT_NEAR(maps.fringe_order_doubt.begin()[i], expected_maps.fringe_order_doubt.begin()[i],
                  1e-4);
    }
  }
  std::cout << taken << " strategies on the GPU, " << left << " not; " << differing << " of "
            << pixels << " pixels differ\n";
  EXPECT_GT(taken, 10U);
  EXPECT_LE(differing, pixels / 100'000 + 1);
}

TEST_F(OnGpu, HasThePointsOfTheEquationsForAnyScanner) {
  int scanners = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Scanner scanner = random_scanner(seed, seed % 3 == 0 ? 0 : 0.08);
    scanner.camera.size = {161, 120};
    scanner.camera.intrinsic.topRows<2>() /= 4;
    const Strategy strategy = DualFrequency{.steps = 3, .high = 16, .low = 1};
    for (const Axis axis : {Axis::x, Axis::y}) {
      const EngineSetup setup = setup_of(scanner, strategy, axis);
      if (!FusedEngine::make(setup, {})) continue;
      SCOPED_TRACE(fmt::format("scanner {}, axis {}", seed, name_of(axis)));
      const FrameSet frames = take_scan(scanner, scene_named("board", scanner),
                                        pattern_set(strategy, axis), {.bits = 12})
                                  .frames;
      const Agreement agreement = gpu_agreement(setup, frames);
      EXPECT_LE(agreement.other_validity, 2U);
      EXPECT_LE(agreement.worst, depth_bound);
      scanners += agreement.points > 1000 ? 1 : 0;
    }
  }
  EXPECT_GE(scanners, 12);
}

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

TEST_F(OnGpu, LeavesOutTheSamePixelsForTheSameReasons) {
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
    const Cloud cloud = cloud_of(gpu.value(), frames);
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

TEST_F(OnGpu, OfNoiseIsThatOfTheEquations) {
  const Scanner scanner = example_scanner({203, 151});
  for (const Strategy& strategy : {Strategy(PhaseMeasuring{.steps = 4, .frequency = 1}),
                                   Strategy(DualFrequency{.steps = 3})}) {
    std::mt19937 random(7);
    FrameSet::Images8 images;
    for (int n = 0; n < frame_count(strategy); ++n) {
      images.emplace_back(scanner.camera.size);
      for (std::uint8_t& pixel : images.back()) pixel = static_cast<std::uint8_t>(random());
    }
    const Agreement agreement =
        gpu_agreement(setup_of(scanner, strategy, Axis::x), FrameSet(images));
    EXPECT_GT(agreement.points, 500U);
    EXPECT_LE(agreement.other_validity, 30U);
    EXPECT_LE(agreement.worst, depth_bound);
  }
}

/// A response that bends little, corrected by a polynomial, and one that bends much, by a table.
TEST_F(OnGpu, CorrectsForTheResponse) {
  const Scanner scanner = example_scanner({160, 120});
  const Strategy strategy = DualFrequency{.steps = 4, .high = 16, .low = 1};
  for (const double gamma : {1.2, 2.2, 3.0}) {
    SCOPED_TRACE(gamma);
    EngineSetup setup = setup_of(scanner, strategy, Axis::x);
    setup.scanner.photometry.response =
        MeasuredResponse{.response = PowerLaw{gamma}, .gamma = gamma};
    const FrameSet frames =
        statue_frames(scanner, strategy, Axis::x, {.response = PowerLaw{gamma}});
    const Agreement agreement = gpu_agreement(setup, frames, phase_corrections(setup));
    EXPECT_GT(agreement.points, 2000U);
    EXPECT_LE(agreement.other_validity, 2U);
    EXPECT_LE(agreement.worst, depth_bound);
  }
}

TEST_F(OnGpu, GivesDepthAlone) {
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
TEST_F(OnGpu, CutsLargePictures) {
  const Scanner scanner = example_scanner({171, 91});
  Image<float> coarse(scanner.camera.size);
  for (int i = 0; i < 171 * 91; ++i) coarse.begin()[i] = static_cast<float>(i % 171) / 171;
  for (const Strategy& strategy :
       {Strategy(DualFrequency{}), Strategy(PhaseMeasuring{.frequency = 4})}) {
    const EngineSetup setup =
        setup_of(scanner, strategy, Axis::x, {.nearest = 490, .farthest = 610});
    const auto fused = FusedEngine::make(setup, {}).value();
    const Image<float>* const given = fused.wants_coarse() ? &coarse : nullptr;
    const FrameSet frames =
        statue_frames(scanner, strategy, Axis::x, {.bits = given != nullptr ? 8 : 12});
    struct Results {
      Cloud cloud;
      Maps maps;
      Image<std::uint16_t> numbers;
    };
    const auto results_of = [&](std::size_t pixels) {
      const auto gpu = GpuEngine::make(fused, std::nullopt, pixels).value();
      GpuScanMemory memory;
      Results results;
      gpu(frames, {.cloud = &results.cloud, .maps = &results.maps}, memory, given);
      gpu(frames, {.numbers = &results.numbers}, memory, given);
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

/// Where the picture gives the order, the coordinate so found is handed to the device.
TEST_F(OnGpu, TakesOrdersOfThePicture) {
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

/// A device that is lost costs no cloud: the processor makes the same points from then on, and a
/// new engine has the device again.
TEST_F(OnGpu, GoesOnWithoutADeviceThatIsLost) {
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

TEST_F(OnGpu, IsSharedByThreads) {
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
TEST_F(OnGpu, KeepsItsMemoryFlat) {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "a sanitizer keeps memory of its own";
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

TEST_F(OnGpu, RefusesADeviceThatIsNotThere) {
  const Scanner scanner = example_scanner({64, 48});
  EXPECT_THROW(
      Engine(scanner, {.strategy = DualFrequency{}}, {.engine = EngineKind::gpu, .gpu = 99}),
      WorldError);
}

}  // namespace
}  // namespace slipstream
