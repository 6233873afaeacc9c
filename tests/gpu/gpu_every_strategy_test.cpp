// The GPU gives what the fused pass gives, for every strategy that its shaders take.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <numbers>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "reconstruct/engine_setup.h"
#include "reconstruct/gpu.h"
#include "reconstruct/gpu/gpu_engine.h"
#include "response/correction.h"
#include "slipstream/named_scenes.h"
#include "slipstream/virtual_scanner.h"
#include "tests/every_strategy.h"
#include "tests/geometry/random_scanner.h"
#include "tests/own_strategies.h"
#include "tests/reconstruct/agreement.h"

namespace slipstream::gpu_every_strategy_test {

/// All that the shaders take, of all that the fused pass does.
std::vector<Strategy> every_strategy_on_gpu() {
  std::vector<Strategy> strategies = every_phase_strategy();

  for (const Strategy& strategy : own_strategies()) strategies.push_back(strategy);
  for (const int steps : {3, 4, 5, 6, 8}) {
    strategies.emplace_back(PhaseChannelMultiplexing{.steps = steps});
  }

  for (const Strategy& strategy :
       {Strategy(PhaseMeasuring{.steps = 3, .frequency = 1}),
        Strategy(PhaseMeasuring{.steps = 5, .frequency = 0.8}),
        Strategy(PhaseMeasuring{.steps = 9, .frequency = 1}),
        Strategy(DualFrequency{.steps = 4, .low_steps = 3, .high = 16, .low = 1}),
        Strategy(DualFrequency{.steps = 6, .high = 8, .low = 0.5}),
        Strategy(PhaseMeasuring{.steps = 3, .frequency = 1}).in_motion(1),
        Strategy(PhaseMeasuring{.steps = 4, .frequency = 1}).in_motion(2, 3),
        Strategy(PhaseMeasuring{.steps = 5, .frequency = 1}).in_motion(2),
        Strategy(PhaseMeasuring{.steps = 6, .frequency = 1}).in_motion(4, 1)}) {
    strategies.push_back(strategy);
  }

  return strategies;
}

/// What a strategy is tried on, of any width, axis and bits.
struct Given {
  EngineSetup setup;
  FrameSet frames;
};

struct Any {
  unsigned number;  ///< of the strategy
  Strategy strategy;

  [[nodiscard]] Size size() const { return {128 + static_cast<int>(7 * number % 64), 91}; }
  [[nodiscard]] Axis axis() const { return number % 2 == 0 ? Axis::x : Axis::y; }
  [[nodiscard]] int bits() const { return 8 + static_cast<int>(number % 9); }
};

constexpr double ambient = 5;

Given statue(const Any& any, Photometry photometry) {
  photometry.ambient = ambient;
  Scanner scanner = example_scanner(any.size());
  scanner.photometry.ambient = ambient;
  return {setup_of(scanner, any.strategy, any.axis()),
          statue_frames(scanner, any.strategy, any.axis(), photometry)};
}

Given quiet(const Any& any) {
  return statue(any, {.noise_variance = 1.55, .bits = any.bits()});
}

/// Where neighbours outvote many pixels.
Given noisy(const Any& any) {
  return statue(any, {.noise_variance = 9});
}

/// Before a response that bends little, corrected by a polynomial, or much, by a table.
Given bent(const Any& any) {
  const double gamma = std::array{1.2, 2.2, 3.0}[any.number % 3];
  Given given = statue(any, {.response = PowerLaw{gamma}});
  given.setup.scanner.photometry.response =
      MeasuredResponse{.response = PowerLaw{gamma}, .gamma = gamma};
  return given;
}

Given random_scanners(const Any& any) {
  for (unsigned seed = any.number + 1;; seed += 100) {
    Scanner scanner = random_scanner(seed, seed % 3 == 0 ? 0 : 0.08);
    scanner.camera.size = {161, 120};
    scanner.camera.intrinsic.topRows<2>() /= 4;
    EngineSetup setup = setup_of(scanner, any.strategy, any.axis());
    const auto fused = FusedEngine::make(setup, {});
    if (!fused || fused->stages->point.solved) continue;
    return {std::move(setup), take_scan(scanner, scene_named("board", scanner),
                                        pattern_set(any.strategy, any.axis()), {.bits = 12})
                                  .frames};
  }
}

Given random_pictures(const Any& any) {
  std::mt19937 random(any.number);
  const Scanner scanner = example_scanner(any.size());
  FrameSet::Images16 images;
  for (int n = 0; n < frame_count(any.strategy); ++n) {
    images.emplace_back(scanner.camera.size);
    for (std::uint16_t& pixel : images.back()) pixel = static_cast<std::uint16_t>(random());
  }
  return {setup_of(scanner, any.strategy, any.axis()), FrameSet(std::move(images), 16)};
}

struct Scene {
  const char* name;
  Given (*given)(const Any&);
  /// Of a strategy whose pixels meet a threshold exactly there, so that rounding decides in double
  /// too: one in 20,000 of all pixels may differ by it, beside one in 100,000 by the others.
  std::string_view ties{};
};

void PrintTo(const Scene& scene, std::ostream* out) {
  *out << scene.name;
}

struct Results {
  Cloud cloud;
  Maps maps;
  Image<std::uint16_t> numbers;
};

/// Both of the same validity at that pixel.
void expect_same(const Results& gpu, const Results& fused, std::size_t i, double full_scale) {
  const auto expect_near = [&](const Image<float>& a, const Image<float>& b, double bound) {
    ASSERT_NEAR(a.begin()[i], b.begin()[i], bound);
  };

  const double grey_level = full_scale / 255;
  expect_near(gpu.maps.mean, fused.maps.mean, 1e-3 * grey_level);
  expect_near(gpu.maps.modulation, fused.maps.modulation, 1e-3 * grey_level);

  if (fused.cloud.validity.begin()[i] != Validity::valid) return;
  expect_near(gpu.cloud.intensity, fused.cloud.intensity, 1e-3);
  expect_near(gpu.maps.coordinate, fused.maps.coordinate, 2e-6);
  const float turned = gpu.maps.wrapped_phase.begin()[i] - fused.maps.wrapped_phase.begin()[i];
  ASSERT_LE(std::abs(std::remainder(turned, 2 * std::numbers::pi_v<float>)), 4e-6F);

  if (gpu.maps.fringe_order_doubt.empty()) return;
  // At either end of the field, the root of a cue's rounding: its cosine is flat there.
  expect_near(gpu.maps.fringe_order_doubt, fused.maps.fringe_order_doubt, 2e-3);
}

class GpuEveryStrategyOnGpu : public testing::TestWithParam<Scene> {
 protected:
  void SetUp() override {
    ASSERT_FALSE(gpu_devices().empty()) << "mesa-vulkan-drivers is not installed";
  }
};

/// The pixels of the fused pass, and the points of the equations.
TEST_P(GpuEveryStrategyOnGpu, GivesTheSame) {
  std::size_t pixels = 0, points = 0, differing = 0, ties = 0;
  unsigned number = 0;
  for (const Strategy& strategy : every_strategy_on_gpu()) {
    const Any any{number++, strategy};
    const Given given = GetParam().given(any);
    const auto& [setup, frames] = given;
    SCOPED_TRACE(fmt::format("{}, {} bits, width {}, axis {}", label_of(strategy), any.bits(),
                             frames.size().width, name_of(any.axis())));

    // 1. The cloud and maps of both.
    const PhaseCorrections corrections = phase_corrections(setup);
    const auto fused = FusedEngine::make(setup, corrections);
    ASSERT_TRUE(fused);
    const auto on_gpu = GpuEngine::make(*fused, std::nullopt);
    ASSERT_TRUE(on_gpu);

    Results gpu, expected;
    FusedMemory memory;
    (*fused)(frames, {.cloud = &expected.cloud, .maps = &expected.maps}, memory);
    GpuScanMemory gpu_memory;
    (*on_gpu)(frames, {.cloud = &gpu.cloud, .maps = &gpu.maps}, gpu_memory);

    // 2. The same pixels are rejected for the same reasons, and the others have the same values.
    const std::size_t count = gpu.cloud.z.pixel_count();
    pixels += count;
    const bool may_tie =
        !GetParam().ties.empty() && label_of(strategy).starts_with(GetParam().ties);
    for (std::size_t i = 0; i < count; ++i) {
      if (gpu.cloud.validity.begin()[i] != expected.cloud.validity.begin()[i]) {
        ++(may_tie ? ties : differing);
        continue;
      }
      ASSERT_NO_FATAL_FAILURE(expect_same(gpu, expected, i, frames.views().full_scale()));
    }

    // 3. The points are those of the equations.
    const Agreement agreement = compare(setup.scanner, setup.sequence.axis, gpu.cloud,
                                        by_equations(setup, frames, corrections));
    EXPECT_LE(agreement.worst, depth_bound);
    points += agreement.points;
  }

  std::cout << number << " strategies, " << points << " points; " << differing << " of " << pixels
            << " pixels differ, and " << ties << " by ties\n";
  EXPECT_GT(points, 1000U * number);
  EXPECT_LE(differing, pixels / 100'000);
  EXPECT_LE(ties, pixels / 20'000);
}

INSTANTIATE_TEST_SUITE_P(Scenes, GpuEveryStrategyOnGpu,
                         testing::Values(Scene{"quiet", quiet},
                                         Scene{"noisy", noisy, "two-frequency-4n"},
                                         Scene{"bent", bent, "pcmp, steps 5"},
                                         Scene{"random_scanners", random_scanners},
                                         Scene{"random_pictures", random_pictures}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace slipstream::gpu_every_strategy_test
