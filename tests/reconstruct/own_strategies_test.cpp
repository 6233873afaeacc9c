// Strategies that are layouts alone, known to no part of the library or to its registry, through
// every engine.
#include "tests/own_strategies.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "bench/vector_target.h"
#include "codes/predicted_variance.h"
#include "decode/equations.h"
#include "slipstream/engine.h"
#include "slipstream/unwrapping.h"
#include "tests/every_strategy.h"
#include "tests/reconstruct/agreement.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream::own_strategies_test {

std::string text_of(const Strategy& strategy) {
  std::string text = strategy.name();
  for (const auto& [name, value] : strategy.settings()) text += " " + value.text();
  return text;
}

/// Those that take the right order under the noise of a camera.
std::vector<Strategy> certain_strategies() {
  std::vector<Strategy> strategies = own_strategies();
  for (const Strategy& strategy : every_phase_strategy()) strategies.push_back(strategy);
  return strategies;
}

/// All that the fused pass takes.
std::vector<Strategy> fused_strategies() {
  std::vector<Strategy> strategies = certain_strategies();
  for (const Strategy& strategy : every_strategy_on_cpu()) strategies.push_back(strategy);
  return strategies;
}

/// A Gray code beside a coarse and a fine band; the weights of the coarse mean are exact numbers.
struct CodedBands {
  static constexpr std::string_view name = "coded-bands";

  bool against_coarse = false;  ///< compares bits with the coarse band's mean, else with themselves

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("against_coarse", "whether bits are compared with the coarse mean", self.against_coarse);
  }

  void require_valid() const {}
  [[nodiscard]] double shape(int n, double y) const {
    if (n >= 7) return code_intensity(*layout().code, n - 7, y);
    const double periods = n < 4 ? y - n / 4.0 : 16 * y - (n - 4) / 3.0;
    return 0.5 + 0.5 * std::cos(2 * std::numbers::pi * periods);
  }
  [[nodiscard]] Layout layout() const {
    Layout made{.frames = 13,
                .bands = {phase_shifted_band(13, 0, 4, 1), phase_shifted_band(13, 4, 3, 16)},
                .code = Code{.stripes = 64, .frames = {7, 8, 9, 10, 11, 12}},
                .unwrapping = Unwrapping::code};
    if (against_coarse) made.code->reference = made.bands.front().mean;
    return made;
  }
};

std::vector<Strategy> fused_strategies_and_codes() {
  std::vector<Strategy> strategies = fused_strategies();
  for (const Strategy& strategy : every_code()) strategies.push_back(strategy);
  return strategies;
}

/// Whose maps must be those of the equations; nothing says how many points they give.
std::vector<Strategy> decoded_strategies() {
  std::vector<Strategy> strategies = fused_strategies_and_codes();
  for (const Strategy& strategy :
       {Strategy(CodedBands{}), Strategy(CodedBands{.against_coarse = true}),
        Strategy(ModulatedPhaseShifting{.periods = {1}})}) {
    strategies.push_back(strategy);
  }
  return strategies;
}

std::vector<Strategy> phase_strategies() {
  std::vector<Strategy> strategies = fused_strategies();
  for (const Strategy& strategy : every_strategy_with_cue()) strategies.push_back(strategy);
  return strategies;
}

TEST(OwnStrategies, ComeOutAtTheirTrueDepth) {
  const Scanner scanner = example_scanner({160, 120});
  for (const Strategy& strategy : phase_strategies()) {
    for (const Axis axis : {Axis::x, Axis::y}) {
      SCOPED_TRACE(text_of(strategy) + ", axis " + std::string(name_of(axis)));
      const VirtualScan scan =
          scan_of_scene("boxes", scanner, pattern_set(strategy, axis), {.bits = std::nullopt});
      for (const PhaseMethod method :
           {PhaseMethod::equation, PhaseMethod::closed_form, PhaseMethod::tables}) {
        const ReferenceEngine reconstruct(
            setup_of(scanner, strategy, axis, {.phase_method = method}), {});
        const BasicCloud<double> cloud = reconstruct(scan.frames).cloud;
        std::size_t points = 0, lit = 0;
        for (std::size_t i = 0; i < scan.depth.pixel_count(); ++i) {
          lit += std::isnan(scan.coordinate.begin()[i]) ? 0 : 1;
          if (std::isnan(cloud.z.begin()[i])) continue;
          ++points;
          ASSERT_NEAR(cloud.z.begin()[i], scan.depth.begin()[i], 1e-6);
        }
        EXPECT_EQ(points, lit);
        EXPECT_GT(points, 1500U);
      }
    }
  }
}

/// Without a phase the depth is known to the stripe.
TEST(OwnStrategies, CodesComeOutWithinTheirStripe) {
  const Scanner scanner = example_scanner({160, 120});
  for (const Strategy& strategy : every_code()) {
    for (const Axis axis : {Axis::x, Axis::y}) {
      const int length = length_along(axis, scanner.projector.size);
      SCOPED_TRACE(label_of(strategy) + ", axis " + std::string(name_of(axis)));
      const VirtualScan scan = scan_of_scene("boxes", scanner, pattern_set(strategy, axis), {});
      Engine engine(setup_of(scanner, strategy, axis, {.minimum_modulation = 1}));
      EXPECT_EQ(engine.backend_for(scan.frames), "fused");
      Cloud cloud;
      Maps maps;
      engine.cloud_and_maps(scan.frames, cloud, maps);
      EXPECT_GT(point_count(cloud), 1500U);
      EXPECT_EQ(std::count(cloud.validity.begin(), cloud.validity.end(), Validity::saturated), 0)
          << "bright bits may be";
      const double half = 0.5 / strategy.layout().code->stripes + 0.5 / length;
      for (std::size_t i = 0; i < maps.coordinate.pixel_count(); ++i) {
        if (cloud.validity.begin()[i] != Validity::valid) continue;
        ASSERT_NEAR(maps.coordinate.begin()[i], scan.coordinate.begin()[i], half + 1e-6);
      }
    }
  }
}

/// To be taken again under other patterns.
VirtualScan statue_scan(const Scanner& scanner, Axis axis) {
  return scan_of_scene("statue", scanner, pattern_set(PhaseMeasuring{}, axis));
}

/// A code without a bit more than numbers the periods: where the phase wraps it may be one off.
bool nothing_confirms(const Strategy& strategy) {
  const auto& code = strategy.layout().code;
  return code && code->stripes == highest_frequency(strategy);
}

/// Under noise too: within the noise that is predicted for each pixel, and on the right fringe.
TEST(OwnStrategies, ComeOutAtTheTruthUnderNoise) {
  Scanner scanner = example_scanner({640, 480});
  const Photometry photometry{.ambient = 5, .noise_variance = 1.55};
  scanner.photometry.noise_variance = photometry.noise_variance + quantisation_variance;
  const VirtualScan scan = statue_scan(scanner, Axis::x);
  for (const Strategy& strategy : certain_strategies()) {
    const FrameSet frames = take_again(scan, pattern_set(strategy, Axis::x), photometry);
    for (const EngineKind kind : {EngineKind::reference, EngineKind::fused}) {
      SCOPED_TRACE(text_of(strategy) + (kind == EngineKind::fused ? ", fused" : ", reference"));
      Engine engine(setup_of(scanner, strategy, Axis::x, {.engine = kind}));
      EXPECT_EQ(engine.backend_for(frames) == "fused", kind == EngineKind::fused);
      Cloud cloud;
      Maps maps;
      engine.cloud_and_maps(frames, cloud, maps);
      const Uncertainty sigma = engine.uncertainty(cloud, maps, frames);
      std::size_t points = 0, wrong = 0, far = 0;
      for (std::size_t i = 0; i < scan.depth.pixel_count(); ++i) {
        if (cloud.validity.begin()[i] != Validity::valid) continue;
        ++points;
        const double error = std::abs(maps.coordinate.begin()[i] - scan.coordinate.begin()[i]);
        wrong += error < 0.5 / highest_frequency(strategy) ? 0 : 1;
        far += error < 7 * sigma.coordinate.begin()[i] ? 0 : 1;
      }
      EXPECT_GT(points, 225000U);
      const bool unconfirmed = nothing_confirms(strategy);
      EXPECT_LE(wrong, unconfirmed ? points / 2000 : 0);
      EXPECT_LE(far, unconfirmed ? points / 2000 : 0);
    }
  }
}

/// Where noise carries the coarse phases off their fringe, the neighbours and the doubt find it.
TEST(OwnStrategies, ShowNoPointOfAWrongFringeOrder) {
  const Scanner scanner = example_scanner({640, 480});
  const VirtualScan scan = statue_scan(scanner, Axis::x);
  for (const Strategy& strategy :
       {Strategy(ThreeFrequencies{}), Strategy(ThreeFrequencies{6, 36, 1})}) {
    const FrameSet frames =
        take_again(scan, pattern_set(strategy, Axis::x), {.ambient = 5, .noise_variance = 12});
    const auto wrong_with = [&](EngineKind kind, const FringeOrderConsensus& consensus) {
      Engine engine(
          setup_of(scanner, strategy, Axis::x,
                   {.engine = kind, .minimum_modulation = 10, .fringe_order = consensus}));
      Cloud cloud;
      engine.cloud(frames, cloud);
      int wrong = 0;
      for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
        // A fringe is about 55 mm deep here.
        wrong += std::abs(cloud.z.begin()[i] - scan.depth.begin()[i]) > 27 ? 1 : 0;
      }
      return wrong;
    };
    for (const EngineKind kind : {EngineKind::reference, EngineKind::fused}) {
      EXPECT_GT(wrong_with(kind, {.fewest_neighbours = 0, .fewest_if_doubtful = 0}), 20)
          << "else this shows nothing";
      EXPECT_EQ(wrong_with(kind, {}), 0);
    }
  }
}

/// Frames and equations once for all targets, as they take longer than the engine.
TEST(OwnStrategies, HaveThePointsOfTheEquationsOnEachTarget) {
  for (const int width : {160, 171}) {
    const Scanner scanner = example_scanner({width, 90});
    const Axis axis = width == 160 ? Axis::x : Axis::y;
    const VirtualScan scan = statue_scan(scanner, axis);
    std::vector<Strategy> strategies = fused_strategies_and_codes();
    strategies.push_back(Strategy(PhaseMeasuring{3, 1}).in_motion(1));
    strategies.push_back(Strategy(PhaseMeasuring{4, 1}).in_motion(2));
    strategies.push_back(Strategy(PhaseMeasuring{5, 1}).in_motion(2));

    for (const Strategy& strategy : strategies) {
      const EngineSetup setup = setup_of(scanner, strategy, axis);
      for (const auto& [bits, noise] :
           {std::pair{8, 0.0}, {8, 1.55}, {8, 6.0}, {12, 1.55}, {16, 0.0}}) {
        const FrameSet frames = take_again(scan, pattern_set(strategy, axis),
                                           {.ambient = 5, .noise_variance = noise, .bits = bits});
        const ReferenceResult exact = by_equations(setup, frames);

        for (const std::string& target : vector_targets()) {
          SCOPED_TRACE(testing::Message() << text_of(strategy) << ", width " << width << ", noise "
                                          << noise << ", bits " << bits << ", " << target);
          const OnlyVectorTarget only(target);
          const Agreement agreement = agreement_with(exact, setup, frames);
          EXPECT_GT(agreement.points, 2000U);
          // A modulation that is just the least asked for is so to the rounding of its weights.
          EXPECT_LE(agreement.other_validity, step_counts(strategy).empty() ? 4U : 1U);
          EXPECT_LE(agreement.other_intensity, 1U);
          EXPECT_LE(agreement.worst, depth_bound);
        }
      }
    }
  }
}

class OwnStrategiesOn : public testing::TestWithParam<std::string> {};

TEST_P(OwnStrategiesOn, DecodeToTheMapsOfTheEquations) {
  const OnlyVectorTarget only(GetParam());
  for (const int width : {64, 203}) {
    const Scanner scanner = example_scanner({width, 120});
    for (const Strategy& strategy : decoded_strategies()) {
      SCOPED_TRACE(testing::Message() << text_of(strategy) << ", width " << width);
      const EngineSetup setup = setup_of(scanner, strategy, Axis::x);
      const FrameSet frames = statue_frames(scanner, strategy, Axis::x,
                                            {.ambient = 5, .noise_variance = 1.55, .bits = 12});
      const BasicMaps<double> exact = by_equations(setup, frames).maps;
      Maps made;
      Engine(setup).maps(frames, made);
      ASSERT_EQ(made.coordinate.size(), exact.coordinate.size());
      ASSERT_EQ(made.fringe_order_doubt.size(), exact.fringe_order_doubt.size());
      std::size_t other_order = 0;
      for (std::size_t i = 0; i < exact.coordinate.pixel_count(); ++i) {
        ASSERT_NEAR(made.modulation.begin()[i], exact.modulation.begin()[i], 2e-3);
        ASSERT_NEAR(made.mean.begin()[i], exact.mean.begin()[i], 1e-2);
        if (exact.modulation.begin()[i] < 16) continue;  // of 4095
        const double turned = std::remainder(
            made.wrapped_phase.begin()[i] - exact.wrapped_phase.begin()[i], 2 * std::numbers::pi);
        ASSERT_NEAR(turned, 0, 2e-6);
        if (std::abs(made.coordinate.begin()[i] - exact.coordinate.begin()[i]) > 1e-3) {
          ++other_order;
          continue;
        }
        ASSERT_NEAR(made.coordinate.begin()[i], exact.coordinate.begin()[i], 4e-7);
        if (exact.fringe_order_doubt.empty()) continue;
        ASSERT_NEAR(made.fringe_order_doubt.begin()[i], exact.fringe_order_doubt.begin()[i], 1e-3);
      }
      // Bits of pixels that are lit by a grey level of 255 leave both orders as near as another.
      EXPECT_LE(other_order, strategy.layout().code ? 40U : 2U);
    }
  }
}

/// Also where nothing is lit, or all is saturated.
TEST_P(OwnStrategiesOn, GiveEachPixelACoordinateInTheField) {
  const OnlyVectorTarget only(GetParam());
  const Scanner scanner = example_scanner({37, 5});
  for (const Strategy& strategy : decoded_strategies()) {
    const EngineSetup setup = setup_of(scanner, strategy, Axis::x);
    const double unlit = std::max(1 / least_periods(strategy.layout()) - 1, 0.0);
    const double end = 0.5 / scanner.projector.size.width + unlit / 2 + 1e-6;
    for (const int level : {0, 1, 255}) {
      SCOPED_TRACE(testing::Message() << text_of(strategy) << ", level " << level);
      Maps maps;
      Engine(setup).maps(FrameSet(FrameSet::Images8(
                             static_cast<std::size_t>(strategy.layout().frames),
                             Image<std::uint8_t>({37, 5}, static_cast<std::uint8_t>(level)))),
                         maps);
      for (const float y : maps.coordinate) {
        ASSERT_GE(y, -end);
        ASSERT_LT(y, 1 + end);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(VectorTarget, OwnStrategiesOn, testing::ValuesIn(vector_targets()),
                         [](const auto& info) { return info.param; });

/// Over the whole field: where C and S have noise in common, single phases have more or less of it.
TEST(OwnStrategies, NoiseOfTheCoordinateIsAsPredicted) {
  constexpr int length = 900, rows = 80;
  constexpr double alpha = 0.6, ambient = 5, noise_variance = 1.55;
  constexpr PatternLight light{.alpha_p = 200, .beta_p = 20};
  std::vector<Strategy> strategies = certain_strategies();
  for (const Strategy& strategy : every_strategy_on_cpu()) {
    if (carrier_periods(strategy.layout()) > 0) strategies.push_back(strategy);
  }
  for (const Strategy& strategy : strategies) {
    SCOPED_TRACE(text_of(strategy));
    const PatternSet patterns = pattern_set(strategy, Axis::x, light);
    std::mt19937_64 random(7);
    std::normal_distribution<double> w(0, std::sqrt(noise_variance));
    const auto coordinate = [](int column) { return static_cast<double>(column) / length; };
    FrameSet::ImagesUnquantised images;
    for (int n = 0; n < patterns.count; ++n) {
      Image<double>& image = images.emplace_back(Size{length, rows});
      for (int row = 0; row < rows; ++row) {
        for (int i = 0; i < length; ++i) {
          const double across = static_cast<double>(row) / rows;
          const double lit = patterns.intensity(n, coordinate(i), across) + ambient;
          image(i, row) = alpha * lit + ambient + w(random);  // (3.2)
        }
      }
    }
    const Decoder decode(strategy.layout(), length, PhaseMethod::equation);
    const BasicMaps<double> maps = decode(FrameSet(std::move(images)));
    const double half = 0.5 / highest_frequency(strategy);
    double square = 0;
    for (int row = 0; row < rows; ++row) {
      for (int i = 0; i < length; ++i) {
        double error = maps.coordinate(i, row) - coordinate(i);
        // One period cannot tell one end of the field from the other.
        if (least_periods(strategy.layout()) == 1 && is_circle(strategy.layout()))
          error = std::remainder(error, 1);
        if (nothing_confirms(strategy) && std::abs(error) > half) continue;
        ASSERT_LT(std::abs(error), half) << "column " << i;
        square += error * error;
      }
    }
    const double share = measuring_band(strategy.layout()).share;
    const double predicted =
        coordinate_variance(strategy.layout(), share * alpha * light.alpha_p / 2, noise_variance);
    EXPECT_NEAR(square / (length * rows) / predicted, 1, 0.05);
  }
}

/// Tables of N steps and their corrections serve a layout whose bands are runs of steps, or two of
/// them with a carrier.
TEST(OwnStrategies, AreCorrectedForTheResponseWhereTheyAreRunsOfSteps) {
  Scanner scanner = example_scanner({160, 120});
  for (const Strategy& strategy :
       {Strategy(ThreeFrequencies{}), Strategy(ModulatedPhaseShifting{.periods = {1, 4, 16}})}) {
    SCOPED_TRACE(text_of(strategy));
    const VirtualScan scan = scan_of_scene("board", scanner, pattern_set(strategy, Axis::x),
                                           {.response = PowerLaw{1.6}, .bits = 16});
    const auto rms_depth_error = [&](EngineKind kind) {
      Cloud cloud;
      Engine(setup_of(scanner, strategy, Axis::x, {.engine = kind})).cloud(scan.frames, cloud);
      double sum = 0, points = 0;
      for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
        const double error = cloud.z.begin()[i] - scan.depth.begin()[i];
        if (!std::isfinite(error)) continue;
        sum += error * error;
        ++points;
      }
      EXPECT_GT(points, 10000);
      return std::sqrt(sum / points);
    };
    for (const EngineKind kind : {EngineKind::reference, EngineKind::fused}) {
      scanner.photometry.response.reset();
      EXPECT_GT(rms_depth_error(kind), 0.5);
      scanner.photometry.response = MeasuredResponse{.response = PowerLaw{1.6}, .gamma = 1.6};
      EXPECT_LT(rms_depth_error(kind), 0.01);
    }
  }
}

}  // namespace slipstream::own_strategies_test
