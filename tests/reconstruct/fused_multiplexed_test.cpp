// Cues in the frames through the fused pass: the points, reasons and images of the reference
// engine.
#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "bench/vector_target.h"
#include "decode/decoder.h"
#include "decode/phase_decoder.h"
#include "reconstruct/engine_setup.h"
#include "slipstream/engine.h"
#include "tests/reconstruct/agreement.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream::fused_multiplexed_test {

constexpr double ambient = 5;

PhaseChannelMultiplexing pcmp(int steps) {
  return {.steps = steps, .high = {}, .share = {}, .reference = {}};
}

EngineSetup setup_of_cue(const Scanner& scanner, const Strategy& strategy, Axis axis,
                         const ReconstructSettings& settings = {}) {
  EngineSetup setup = setup_of(scanner, strategy, axis, settings);
  setup.scanner.photometry.ambient = ambient;
  return setup;
}

EngineSetup setup_for_pcmp(const Scanner& scanner, int steps, Axis axis = Axis::x,
                           const ReconstructSettings& settings = {}) {
  return setup_of_cue(scanner, pcmp(steps), axis, settings);
}

/// With PCMP's sums in integers, by weights that mirror, and by any weights; and pcps, whose cue is
/// linear in other channels.
std::vector<Strategy> strategies_with_cue() {
  std::vector<Strategy> strategies;
  for (const int steps : {3, 4, 5, 8}) strategies.emplace_back(pcmp(steps));
  for (const int steps : {3, 4, 5}) {
    strategies.push_back(Strategy(pcmp(steps)).in_motion(2));
    strategies.push_back(Strategy(pcmp(steps)).in_motion(3, 1));
  }
  for (const int steps : {4, 6, 8}) strategies.emplace_back(PeriodCoded{.steps = steps});
  const Shifts elsewhere{.origin = 2.1, .backwards = true};
  strategies.emplace_back(PeriodCoded{.steps = 6, .high = 16, .shifts = elsewhere});
  strategies.emplace_back(PhaseChannelMultiplexing{.steps = 4, .shifts = elsewhere});
  return strategies;
}

/// Photometry at which many pixels are of a wrong order before the neighbours are asked.
const Photometry noisy{.ambient = ambient, .noise_variance = 6};

/// Frames and equations once for all targets, as they take longer than the engine.
TEST(FusedMultiplexed, HasThePointsOfTheEquationsOnEachTarget) {
  for (const int width : {160, 171}) {
    const Scanner scanner = example_scanner({width, 90});
    const Axis axis = width == 160 ? Axis::x : Axis::y;
    for (const Strategy& strategy : strategies_with_cue()) {
      const EngineSetup setup = setup_of_cue(scanner, strategy, axis);
      for (const Photometry& photometry : {Photometry{.ambient = ambient}, noisy}) {
        const FrameSet frames = statue_frames(scanner, strategy, axis, photometry);
        const ReferenceResult exact = by_equations(setup, frames);

        for (const std::string& target : vector_targets()) {
          SCOPED_TRACE(testing::Message()
                       << strategy.name() << ", " << strategy.layout().frames << " frames, width "
                       << width << ", noise " << photometry.noise_variance << ", " << target);
          const OnlyVectorTarget only(target);
          const Agreement agreement = agreement_with(exact, setup, frames);
          EXPECT_GT(agreement.points, 2000U);
          EXPECT_LE(agreement.other_validity, 1U);
          EXPECT_LE(agreement.other_intensity, 1U);
          EXPECT_LE(agreement.worst, depth_bound);
        }
      }
    }
  }
}

class FusedMultiplexedOn : public testing::TestWithParam<std::string> {};

/// Three rows each of random pixels, black, white, one frame full, and one frame constant.
std::vector<Image<std::uint16_t>> hard_frames(int count, Size size, int full, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Image<std::uint16_t>> frames(static_cast<std::size_t>(count),
                                           Image<std::uint16_t>(size));
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const std::size_t one = static_cast<std::size_t>(column) % frames.size();
      for (std::size_t n = 0; n < frames.size(); ++n) {
        const auto level = static_cast<int>(random() >> (32 - std::bit_width(unsigned(full))));
        const int kinds[] = {level, 0, full, n == one ? full : level / 2,
                             n == 1 ? full / 3 : level};
        frames[n](column, row) = static_cast<std::uint16_t>(kinds[row / 3 % 5]);
      }
    }
  }
  return frames;
}

TEST_P(FusedMultiplexedOn, HasThePointsOfTheEquationsForEveryInput) {
  const OnlyVectorTarget only(GetParam());
  const Scanner scanner = example_scanner({67, 60});
  for (const int steps : {3, 4, 5, 6}) {
    for (const int bits : {8, 12, 16}) {
      const int full = (1 << bits) - 1;
      const FrameSet frames(
          hard_frames(steps, scanner.camera.size, full, static_cast<unsigned>(7 * bits)), bits);
      for (const double least : {15.0, 1.0}) {
        SCOPED_TRACE(testing::Message() << steps << " steps, " << bits << " bits, least " << least);
        const ReconstructSettings all{.minimum_modulation = least, .drop_saturated = least > 1};
        const Agreement agreement =
            agreement_on(setup_for_pcmp(scanner, steps, Axis::x, all), frames);
        EXPECT_GT(agreement.points, 100U);
        // Phases of few grey levels are fractions that lie half a period apart to the last bit.
        EXPECT_LE(agreement.other_validity, bits == 8 ? 12U : 2U);
        EXPECT_LE(agreement.worst, depth_bound);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(VectorTarget, FusedMultiplexedOn, testing::ValuesIn(vector_targets()),
                         [](const auto& info) { return info.param; });

/// Eight steps with a cue in their mean whose reference is a cosine.
struct CosineInMean {
  static constexpr std::string_view name = "cosine-in-mean";

  template <class Self, class Visit>
  static void for_each_setting(Self&, const Visit&) {}

  void require_valid() const {}
  [[nodiscard]] double shape(int n, double y) const {
    const double fringes = std::cos(2 * std::numbers::pi * (6 * y - n / 8.0));
    return 0.5 + 0.25 * fringes + 0.25 * std::cos(std::numbers::pi * std::clamp(y, 0.0, 1.0));
  }
  [[nodiscard]] Layout layout() const {
    return {.frames = 8,
            .bands = {phase_shifted_band(8, 0, 8, 6, 1, 0.5)},
            .cue = Cue{.share = 0.5,
                       .weights = mean_weights(8),
                       .reference = CueReference(CueReference::Form::cosine)},
            .unwrapping = Unwrapping::vote};
  }
};

TEST(FusedMultiplexed, ShowsTheMeanWithoutItsCosine) {
  const Scanner scanner = example_scanner({160, 90});
  const Strategy strategy = CosineInMean{};
  const FrameSet frames = statue_frames(scanner, strategy, Axis::x, {.ambient = ambient});

  const Agreement agreement = agreement_on(setup_of_cue(scanner, strategy, Axis::x), frames);
  EXPECT_GT(agreement.points, 1000U);
  EXPECT_LE(agreement.other_intensity, 1U);
}

/// 640x480 at the noise of the benchmark: pixels valid in the one and not in the other are at most
/// 1 in 10000, and no point of either is of a wrong order.
TEST(FusedMultiplexed, HasThePointsOfTheEquationsAndTheTruthInLargePictures) {
  const Scanner scanner = example_scanner({640, 480});
  for (const int steps : {3, 4, 5}) {
    SCOPED_TRACE(testing::Message() << steps << " steps");
    const VirtualScan scan =
        scan_of_scene("statue", scanner, pattern_set(Strategy(pcmp(steps)), Axis::x),
                      {.ambient = ambient, .noise_variance = 1.55});
    const EngineSetup setup = setup_for_pcmp(scanner, steps);
    Engine reconstruct(setup);
    EXPECT_EQ(reconstruct.backend_for(scan.frames), "fused");
    Cloud cloud;
    Maps maps;
    reconstruct.cloud(scan.frames, cloud);
    reconstruct.maps(scan.frames, maps);
    const ReferenceResult exact = by_equations(setup, scan.frames);
    std::size_t points = 0, other = 0, wrong = 0;
    for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
      const bool valid = cloud.validity.begin()[i] == Validity::valid;
      other += cloud.validity.begin()[i] != exact.cloud.validity.begin()[i] ? 1 : 0;
      if (!valid) continue;
      ++points;
      const double error = maps.coordinate.begin()[i] - scan.coordinate.begin()[i];
      wrong += std::abs(error) < 0.5 / pcmp(steps).f_h() ? 0 : 1;
      ASSERT_NEAR(maps.coordinate.begin()[i], exact.maps.coordinate.begin()[i], 2e-7);
    }
    EXPECT_GT(points, 240000U);
    EXPECT_LE(10000 * other, points);
    EXPECT_EQ(wrong, 0U);
  }
}

TEST(FusedMultiplexed, DecodesToTheImagesOfTheEquations) {
  const Scanner scanner = example_scanner({203, 120});
  for (const int steps : {3, 4, 5, 6}) {
    SCOPED_TRACE(testing::Message() << steps << " steps");
    const FrameSet frames =
        statue_frames(scanner, pcmp(steps), Axis::x,
                      {.ambient = ambient, .noise_variance = noisy.noise_variance, .bits = 12});
    const EngineSetup setup = setup_for_pcmp(scanner, steps);
    const auto fused = FusedEngine::make(setup, {});
    ASSERT_TRUE(fused);
    Maps made;
    FusedMemory memory;
    (*fused)(frames, {.maps = &made}, memory);
    const Decoder decode(setup.sequence.strategy.layout(), scanner.projector.size.width,
                         PhaseMethod::equation, {}, cue_settings(setup));
    const BasicMaps<double> exact =
        decode(frames, least_neighbour_modulation(setup.settings, frames.full_scale()));
    std::size_t other_order = 0;
    for (std::size_t i = 0; i < exact.coordinate.pixel_count(); ++i) {
      if (exact.modulation.begin()[i] < 16) continue;  // of 4095
      if (std::abs(made.coordinate.begin()[i] - exact.coordinate.begin()[i]) > 1e-3) {
        ++other_order;
        continue;
      }
      ASSERT_NEAR(made.coordinate.begin()[i], exact.coordinate.begin()[i], 4e-7);
      ASSERT_NEAR(made.modulation.begin()[i], exact.modulation.begin()[i], 1e-3);
      ASSERT_NEAR(made.mean.begin()[i], exact.mean.begin()[i], 1e-2);
      ASSERT_NEAR(made.fringe_order_doubt.begin()[i], exact.fringe_order_doubt.begin()[i], 1e-3);
    }
    EXPECT_LE(other_order, 2U);
  }
}

TEST(FusedMultiplexed, IsCorrectedAndIsTheSameOnAnyNumberOfThreads) {
  const Scanner scanner = example_scanner({320, 240});
  const EngineSetup setup = setup_for_pcmp(scanner, 5);
  PhaseCorrection correction{5, {}};
  for (int i = 0; i < 256; ++i) correction.added.push_back(0.05 * std::sin(0.0245436926 * i));
  const PhaseCorrections corrections{{5, correction}};
  const FrameSet frames = statue_frames(scanner, pcmp(5), Axis::x, noisy);
  const Agreement agreement = agreement_on(setup, frames, corrections);
  EXPECT_GT(agreement.points, 20000U);
  EXPECT_LE(agreement.other_validity, 3U);
  EXPECT_LE(agreement.worst, depth_bound);

  const auto reconstruct = FusedEngine::make(setup, corrections);
  FusedMemory memory;
  std::vector<Cloud> clouds(2);
  for (const std::size_t threads : {1U, 4U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    (*reconstruct)(frames, {.cloud = &clouds[threads == 1 ? 0 : 1]}, memory);
  }
  Depth depth;
  (*reconstruct)(frames, {.depth = &depth}, memory);
  for (std::size_t i = 0; i < depth.z.pixel_count(); ++i) {
    ASSERT_EQ(clouds[0].validity.begin()[i], clouds[1].validity.begin()[i]);
    ASSERT_EQ(clouds[0].validity.begin()[i], depth.validity.begin()[i]);
    ASSERT_EQ(clouds[0].intensity.begin()[i], clouds[1].intensity.begin()[i]);
    if (depth.validity.begin()[i] != Validity::valid) continue;
    ASSERT_EQ(clouds[0].z.begin()[i], clouds[1].z.begin()[i]);
    ASSERT_EQ(clouds[0].z.begin()[i], depth.z.begin()[i]);
  }
}

TEST(FusedMultiplexed, LeavesOtherRulesAndReferencesToTheEquations) {
  const Scanner scanner = example_scanner({64, 48});
  const auto fused = [&](const PhaseChannelMultiplexing& strategy, CueRule rule) {
    EngineSetup setup = setup_for_pcmp(scanner, 3, Axis::x, {.cue_rule = rule});
    setup.sequence.strategy = strategy;
    return FusedEngine::make(setup, {}).has_value();
  };
  EXPECT_TRUE(fused(pcmp(3), CueRule::consensus));
  EXPECT_FALSE(fused(pcmp(3), CueRule::published));
  EXPECT_FALSE(fused(pcmp(5), CueRule::likelihood));
  PhaseChannelMultiplexing own = pcmp(4);
  own.reference = [](double y) { return 1 - 2 * y; };
  EXPECT_FALSE(fused(own, CueRule::consensus));
}

}  // namespace slipstream::fused_multiplexed_test
