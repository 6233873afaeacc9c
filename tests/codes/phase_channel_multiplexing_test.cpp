#include "slipstream/phase_channel_multiplexing.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "codes/predicted_variance.h"
#include "decode/cue_evidence.h"
#include "decode/decoder.h"
#include "slipstream/error.h"
#include "slipstream/frame_set.h"
#include "slipstream/strategy.h"

namespace slipstream::phase_channel_multiplexing_test {

constexpr int length = 600;
constexpr double ambient = -7;

/// A picture whose column i has the coordinate (i + 0.49) / length; each row is the same.
struct Shown {
  PhaseChannelMultiplexing strategy;
  PatternLight light{.alpha_p = 200, .beta_p = 55};
  double alpha = 0.6;
  double noise = 0;
  int rows = 1;

  [[nodiscard]] static double coordinate(int column) { return (column + 0.49) / length; }

  [[nodiscard]] FrameSet frames() const {
    const PatternSet patterns = pattern_set(strategy, Axis::x, light);
    std::mt19937_64 random(7);
    std::normal_distribution<double> w(0, 1);
    FrameSet::ImagesUnquantised images;
    for (int n = 0; n < patterns.count; ++n) {
      Image<double>& image = images.emplace_back(Size{length, rows});
      for (int row = 0; row < rows; ++row) {
        for (int i = 0; i < length; ++i) {
          const double lit = patterns.intensity(n, coordinate(i)) + ambient;
          image(i, row) = alpha * lit + ambient + (noise > 0 ? noise * w(random) : 0);  // (3.2)
        }
      }
    }
    return FrameSet(std::move(images));
  }

  [[nodiscard]] BasicMaps<double> decoded(CueRule rule) const {
    // The rules weigh channels by their noise: told of more than there is, they rightly choose
    // among orders that a weak cue can hardly tell apart by what is likely beforehand.
    const CueSettings cue{.light = light,
                          .ambient = ambient,
                          .noise_variance = std::max(noise * noise, 1e-6),
                          .rule = rule};
    return Decoder(strategy.layout(), length, PhaseMethod::equation, {}, cue)(frames());
  }
};

RC_GTEST_PROP(PhaseChannelMultiplexing, GivesTheCoordinateThatWasShown, ()) {
  const int steps = *rc::gen::inRange(3, 10);
  const int high = *rc::gen::inRange(2, 24);
  const double share = 1.0 / high + (1 - 1.0 / high) * *rc::gen::inRange(1, 18) / 20.0;
  const auto rule = *rc::gen::element(CueRule::published, CueRule::likelihood, CueRule::consensus);
  const Shown shown{.strategy = {.steps = steps, .high = high, .share = share, .reference = {}}};
  const BasicMaps<double> scan = shown.decoded(rule);
  for (int i = 0; i < length; ++i) {
    RC_ASSERT(std::abs(scan.coordinate(i, 0) - Shown::coordinate(i)) < 1e-9);
    RC_ASSERT(scan.fringe_order_doubt(i, 0) < 1e-3);
  }
}

TEST(PhaseChannelMultiplexing, TakesAnyMonotonicReference) {
  const auto square = [](double y) { return 1 - 2 * y * y; };
  for (const int steps : {3, 4}) {
    const Shown shown{.strategy = {.steps = steps, .high = 6, .share = 0.5, .reference = square}};
    for (const CueRule rule : {CueRule::published, CueRule::likelihood, CueRule::consensus}) {
      const BasicMaps<double> scan = shown.decoded(rule);
      for (int i = 0; i < length; ++i) {
        ASSERT_NEAR(scan.coordinate(i, 0), Shown::coordinate(i), 1e-9)
            << steps << " steps, " << name_of(rule);
      }
    }
  }
}

TEST(PhaseChannelMultiplexing, DefaultReferencesAreThePublishedOnes) {
  using std::numbers::pi;
  const PhaseChannelMultiplexing three{.steps = 3, .high = {}, .share = {}, .reference = {}};
  const PhaseChannelMultiplexing four{.steps = 4, .high = {}, .share = {}, .reference = {}};
  EXPECT_EQ(three.f_h(), 3);
  EXPECT_EQ(three.c1(), 0.5);
  for (const double y : {0.0, 0.3, 0.9}) {
    EXPECT_DOUBLE_EQ(three.cue_reference()(y), 2 * y - 1);
    EXPECT_DOUBLE_EQ(four.cue_reference()(y), std::cos(pi * y));
    EXPECT_NEAR(four.cue_reference().inverse(four.cue_reference()(y)), y, 1e-12);
    // (3.68) with S[R, 2n, 4] = (-1)^n R
    EXPECT_NEAR(four.shape(1, y),
                0.5 + 0.3 * std::cos(2 * pi * 6 * y - pi / 2) - 0.2 * std::cos(pi * y), 1e-12);
  }
}

TEST(PhaseChannelMultiplexing, RefusesWhatDoesNotPayOrCannotBeTold) {
  const auto made = [](std::optional<double> high, std::optional<double> share, int steps = 5) {
    StrategySettings settings{{"steps", steps}};
    if (high) settings["high"] = *high;
    if (share) settings["share"] = *share;
    return make_strategy("pcmp", settings);
  };
  EXPECT_NO_THROW(made(4, 0.26));
  EXPECT_THROW(made(4, 0.25), Error) << "Eq. (3.64)";
  EXPECT_THROW(made(4, 1), Error);
  EXPECT_THROW(made(1, 0.9), Error);
  EXPECT_THROW(made(4.5, 0.5), Error);
  EXPECT_THROW(made({}, {}, 2), Error);
  EXPECT_THROW(made(std::nan(""), {}), Error);
  EXPECT_THROW(made({}, std::nan("")), Error);
  PhaseChannelMultiplexing folded{.steps = 3, .high = {}, .share = {}, .reference = {}};
  folded.reference = [](double y) { return std::cos(2 * std::numbers::pi * y); };
  EXPECT_THROW(folded.require_valid(), Error);
  folded.reference = [](double y) { return 2 * y; };
  EXPECT_THROW(folded.require_valid(), Error) << "leaves -1 to 1";
  EXPECT_THROW(cue_rule_named("spatial"), Error);
  EXPECT_EQ(cue_rule_named("published"), CueRule::published);
  EXPECT_THROW(require_valid(CueSettings{.ambient = std::nan("")}), Error);
  EXPECT_THROW(require_valid(CueSettings{.noise_variance = 0}), Error);
}

TEST(PhaseChannelMultiplexing, NoiseOfTheCoordinateIsAsPredicted) {
  for (const int steps : {3, 4, 5, 8}) {
    const Shown shown{.strategy = {.steps = steps, .high = {}, .share = {}, .reference = {}},
                      .noise = std::sqrt(1.55),
                      .rows = 60};
    const BasicMaps<double> scan = shown.decoded(CueRule::consensus);
    double square = 0;
    for (int row = 0; row < shown.rows; ++row) {
      for (int i = 0; i < length; ++i) {
        const double error = scan.coordinate(i, row) - Shown::coordinate(i);
        ASSERT_LT(std::abs(error), 0.5 / shown.strategy.f_h()) << steps << " steps, column " << i;
        square += error * error;
      }
    }
    const double modulation = shown.strategy.c1() * shown.alpha * shown.light.alpha_p / 2;
    const double predicted = coordinate_variance(shown.strategy.layout(), modulation, 1.55);
    EXPECT_NEAR(square / (length * shown.rows) / predicted, 1, 0.03) << steps << " steps";
  }
}

TEST(PhaseChannelMultiplexing, TheCueOfThreeStepsDoesNotShadeTheTexture) {
  const Shown shown{.strategy = {.steps = 3, .high = {}, .share = {}, .reference = {}}};
  const BasicMaps<double> scan = shown.decoded(CueRule::consensus);
  const double A = shown.alpha * (100 + 55 + ambient) + ambient;  // (3.3)
  for (int i = 0; i < length; ++i) ASSERT_NEAR(scan.mean(i, 0), A, 1e-9);
}

}  // namespace slipstream::phase_channel_multiplexing_test
