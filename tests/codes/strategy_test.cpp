
#include "slipstream/strategy.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/gray_code.h"
#include "slipstream/sequence.h"
#include "tests/own_strategies.h"

namespace slipstream::strategy_test {

TEST(Strategy, IsMadeFromItsNameAndSettings) {
  const Strategy made =
      make_strategy("dual-frequency", {{"steps", 4}, {"low_steps", 3}, {"high", 8}});
  EXPECT_EQ(made, Strategy(DualFrequency{.steps = 4, .low_steps = 3, .high = 8}));
  EXPECT_EQ(step_counts(made), (std::vector{4, 3}));
  EXPECT_EQ(highest_frequency(made), 8);
  EXPECT_EQ(frame_count(made), 7);
  EXPECT_EQ(made.name(), "dual-frequency");
  EXPECT_EQ(make_strategy(made.name(), made.settings()).settings(), made.settings());
}

TEST(Strategy, RefusesWhatItDoesNotKnow) {
  EXPECT_THROW(make_strategy("gray-code", {}), Error);
  EXPECT_THROW(make_strategy("pmp", {{"high", 16}}), Error);
  EXPECT_THROW(make_strategy("pmp", {{"steps", 2}}), Error);
  EXPECT_THROW(make_strategy("pmp", {{"steps", 3.5}}), Error);
  EXPECT_THROW(make_strategy("pmp", {{"steps", 1e12}}), Error);
  EXPECT_THROW(make_strategy("pmp", {{"frequency", -1}}), Error);
  EXPECT_THROW(make_strategy("pmp", {{"frequency", std::nan("")}}), Error);
  EXPECT_THROW(make_strategy("dual-frequency", {{"low", 2}}), Error);
  EXPECT_THROW(make_strategy("dual-frequency", {{"high", 15.5}}), Error);
  EXPECT_THROW(make_strategy("dual-frequency", {{"low_steps", 2}}), Error);
}

TEST(Strategy, ShiftsReplaceTheSteps) {
  const Strategy made = make_strategy("dual-frequency", {{"shifts", "0,45,120,200,310"}});
  EXPECT_EQ(made, Strategy(DualFrequency{.angles = {0, 45, 120, 200, 310}}));
  EXPECT_EQ(frame_count(made), 10);
  EXPECT_EQ(label_of(made), "dual-frequency, high 16, low 1, shifts 0,45,120,200,310");
  EXPECT_EQ(strategy_labelled(label_of(made)), made);
  EXPECT_TRUE(step_counts(made).empty());
  const Strategy quarters = PhaseMeasuring{.angles = {0, 90, 180, 270}};
  EXPECT_EQ(step_counts(quarters), std::vector{4});
}

TEST(Strategy, ShiftsGiveThePhaseOfAllStrategiesThatHaveThem) {
  const Shifts elsewhere{.origin = 2.1, .backwards = true};
  for (const std::vector<double>& angles :
       {std::vector<double>{0, 90, 180, 270}, {0, 90, 180, 270, 360}, {0, 45, 120, 200, 310}}) {
    for (const Strategy& strategy :
         {Strategy(PhaseMeasuring{.angles = angles}),
          Strategy(PhaseMeasuring{.frequency = 3, .shifts = elsewhere, .angles = angles}),
          Strategy(DualFrequency{.angles = angles}),
          Strategy(MultiFrequency{.shifts = elsewhere, .angles = angles}),
          Strategy(GrayPhase{.periods = 8, .angles = angles})}) {
      for (const double y : {0.0, 0.21, 0.8}) {
        for (const Band& band : strategy.layout().bands) {
          double A = 0, C = 0, S = 0;
          for (int n = 0; n < frame_count(strategy); ++n) {
            const auto i = static_cast<std::size_t>(n);
            A += band.mean[i] * strategy.shape(n, y);
            C += band.cosine[i] * strategy.shape(n, y);
            S += band.sine[i] * strategy.shape(n, y);
          }
          const double phi = 2 * std::numbers::pi * band.periods * y;
          EXPECT_NEAR(A, 0.5, 1e-10) << label_of(strategy);
          EXPECT_NEAR(C, 0.5 * std::cos(phi), 1e-10) << label_of(strategy);
          EXPECT_NEAR(S, 0.5 * std::sin(phi), 1e-10) << label_of(strategy);
        }
      }
    }
  }
}

TEST(Strategy, ShiftsAreRefusedUnlessThreeDiffer) {
  for (const char* shifts : {"0,90", "0,0,0", "0,180,360,540", "0,90,90.5,450", "0,x,90"}) {
    EXPECT_THROW(make_strategy("pmp", {{"shifts", shifts}}), Error) << shifts;
  }
  EXPECT_THROW(Strategy(PhaseMeasuring{.angles = {0, 90, 180, std::nan("")}}), Error);
  EXPECT_THROW(make_strategy("pmp", {{"shifts", "0,90,180"}, {"steps", 3}}), Error);
  EXPECT_THROW(make_strategy("dual-frequency", {{"low_steps", 3}, {"shifts", "0,90,180"}}), Error);
  EXPECT_THROW(make_strategy("micro", {{"shifts", "0,90,180"}}), Error);
}

TEST(Strategy, ShiftsAndStepsReplaceEachOtherInASequence) {
  using Settings = std::map<std::string, std::optional<std::string>>;
  const Sequence known{.strategy = DualFrequency{.low_steps = 5}};
  const auto with = [](const Sequence& sequence, const Settings& settings) {
    return changed(sequence, {.settings = settings});
  };
  const Sequence shifted = with(known, Settings{{"shifts", "0,90,180"}});
  EXPECT_EQ(shifted.strategy, Strategy(DualFrequency{.angles = {0, 90, 180}}));
  EXPECT_EQ(with(shifted, Settings{{"steps", "4"}}).strategy, Strategy(DualFrequency{.steps = 4}));
  EXPECT_THROW(with(known, Settings{{"shifts", "0,90,180"}, {"steps", "3"}}), Error);
}

TEST(Strategy, GrayPhaseHasAllBitsOfACodeWithOrWithoutTheComplementaryOne) {
  EXPECT_NO_THROW(Strategy(GrayPhase{.bits = most_code_bits - 1}));
  EXPECT_NO_THROW(Strategy(GrayPhase{.bits = most_code_bits, .complementary = false}));
  EXPECT_THROW(Strategy(GrayPhase{.bits = most_code_bits}), Error);
  EXPECT_THROW(Strategy(GrayPhase{.bits = most_code_bits + 1, .complementary = false}), Error);
}

TEST(Strategy, GrayPhaseTakesACodeOfItsOwnStripes) {
  const Layout own = GrayPhase{.steps = 3, .periods = 8, .stripes = 960}.layout();
  EXPECT_EQ(own.frames, 3 + 10);
  EXPECT_EQ(own.code->stripes, 960);

  // A complementary bit halves them, as it does without.
  const Layout halved = GrayPhase{.periods = 8, .stripes = 300, .complementary = true}.layout();
  EXPECT_EQ(halved.frames, 4 + 10);
  EXPECT_EQ(halved.code->stripes, 600);

  const double infinite = std::numeric_limits<double>::infinity();
  const double not_a_number = std::numeric_limits<double>::quiet_NaN();
  for (const double stripes : {7.5, 0.0, -8.0, infinite, not_a_number}) {
    EXPECT_THROW(Strategy(GrayPhase{.periods = 8, .stripes = stripes}), Error) << stripes;
    if (stripes == 7.5) continue;
    EXPECT_THROW(Strategy(GrayCode{.stripes = stripes}), Error) << stripes;
  }
  EXPECT_THROW(Strategy(GrayPhase{.periods = 8, .bits = 5, .stripes = 33}), Error);
}

TEST(Strategy, MicroPhaseShiftingInvertsEverySecondSingleFrame) {
  // As SLStudio draws them: cos(2 pi x / p + 2 pi n / 3), then -cos and cos in turn.
  const std::vector<double> pixels{75.02, 70.00, 71.32, 72.47};
  MicroPhaseShifting coding{.periods = {}, .alternating = true, .shifts = {.backwards = true}};
  for (const double length : pixels) coding.periods.push_back(1824 / length);
  const Strategy strategy = coding;
  ASSERT_EQ(frame_count(strategy), 6);
  for (const double x : {0.0, 300.0, 1707.0}) {
    for (int n = 0; n < 6; ++n) {
      const double length = pixels[static_cast<std::size_t>(std::max(n - 2, 0))];
      const double angle = n < 3 ? 2 * std::numbers::pi * n / 3 : n % 2 * std::numbers::pi;
      EXPECT_NEAR(strategy.shape(n, x / 1824),
                  0.5 + 0.5 * std::cos(2 * std::numbers::pi * x / length + angle), 1e-12);
      for (const SingleFrame& single : strategy.layout().single_frames) {
        if (single.frame != n) continue;
        const double phi = 2 * std::numbers::pi * single.periods * x / 1824 + single.origin;
        EXPECT_NEAR(strategy.shape(n, x / 1824), 0.5 + 0.5 * std::cos(phi), 1e-12);
      }
    }
  }
}

TEST(Strategy, KnowsWhetherItGivesACoordinate) {
  EXPECT_TRUE(has_coordinate(PhaseMeasuring{.steps = 3, .frequency = 1}));
  EXPECT_FALSE(has_coordinate(PhaseMeasuring{.steps = 3, .frequency = 16}));
  EXPECT_TRUE(has_coordinate(DualFrequency{}));
}

TEST(Strategy, DescribesEverySettingOnce) {
  const auto settings = strategy_settings();
  const auto steps = std::count_if(settings.begin(), settings.end(),
                                   [](const auto& setting) { return setting.name == "steps"; });
  EXPECT_EQ(steps, 1);
  EXPECT_TRUE(settings.front().strategies.starts_with("pmp 3, dual-frequency 3, pcmp 5, "));
}

TEST(Strategy, OffersUsualOnesThatGiveACoordinate) {
  const std::vector<Strategy> usual = strategies_beside(DualFrequency{.steps = 3, .high = 16});
  ASSERT_EQ(usual.size(), 5U);
  EXPECT_EQ(label_of(usual.front()), "dual-frequency, high 16, low 1, steps 3");
  EXPECT_TRUE(std::all_of(usual.begin(), usual.end(),
                          [](const Strategy& strategy) { return has_coordinate(strategy); }));
}

TEST(Strategy, RefusesFrequenciesThatTheProjectorCannotShow) {
  EXPECT_NO_THROW(require_resolved(DualFrequency{.high = 16}, Axis::x, {1824, 2}));
  EXPECT_THROW(require_resolved(DualFrequency{.high = 16}, Axis::y, {64, 31}), Error);
  const Strategy modulated = ModulatedPhaseShifting{.carrier = 20};
  EXPECT_NO_THROW(require_resolved(modulated, Axis::x, {32, 40}));
  EXPECT_THROW(require_resolved(modulated, Axis::y, {32, 40}), Error);
}

TEST(Strategy, ModulatedPhaseShiftingIsABaseTimesACarrierOrItsObliqueSinusoids) {
  using std::numbers::pi;
  const Strategy product =
      ModulatedPhaseShifting{.carrier_steps = 2, .periods = {1, 6}, .carrier = 20};
  const Strategy oblique = ModulatedPhaseShifting{.periods = {1, 6}, .carrier = 20};
  ASSERT_EQ(frame_count(product), 12);
  ASSERT_EQ(frame_count(oblique), 12);
  for (const double y : {0.0, 0.21, 0.8}) {
    for (const double across : {0.0, 0.013, 0.6}) {
      for (int n = 0; n < 12; ++n) {
        const double base = pi * (n < 6 ? 1 : 6) * y, carrier = 2 * pi * 20 * across;
        const int i = n % 6;
        EXPECT_NEAR(product.shape(n, y, across),
                    0.5 + 0.5 * std::cos(base - 2 * pi * (i / 2) / 3) *
                              std::cos(carrier - pi * (i % 2) / 2),
                    1e-12);
        EXPECT_NEAR(
            oblique.shape(n, y, across),
            0.5 + 0.5 * std::cos(base + (i < 3 ? carrier : -carrier) - 2 * pi * (i % 3) / 3),
            1e-12);
      }
    }
  }
  EXPECT_EQ(step_counts(oblique), (std::vector<int>{3, 3}));
  EXPECT_TRUE(step_counts(product).empty());
  EXPECT_EQ(highest_frequency(product), 6);
}

}  // namespace slipstream::strategy_test

// A struct that declares a coding is a strategy.

namespace slipstream::own_strategies_test {

/// One sinusoid, of the kind that each test needs.
struct Adjustable {
  static constexpr std::string_view name = "adjustable";

  int steps = 4;
  std::optional<double> periods{};
  double sine_of_constant_light = 0;

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("steps", "frames", self.steps);
    visit("periods", "across the field", self.periods);
  }

  void require_valid() const {
    if (steps < 3) throw Error("adjustable: too few steps");
  }
  [[nodiscard]] double shape(int n, double y) const { return n + y; }
  [[nodiscard]] Layout layout() const {
    Layout layout{.frames = steps,
                  .bands = {phase_shifted_band(steps, 0, steps, periods.value_or(1))}};
    layout.bands[0].sine[0] += sine_of_constant_light;
    return layout;
  }
};

TEST(Strategy, OwnStrategySaysWhatItsStructSays) {
  const Strategy plain = Adjustable{}, fine = Adjustable{.steps = 5, .periods = 7};
  EXPECT_EQ(plain.name(), "adjustable");
  EXPECT_EQ(plain.name(), "adjustable");
  EXPECT_EQ(plain.settings(), (StrategySettings{{"steps", 4}}));
  EXPECT_EQ(fine.settings(), (StrategySettings{{"steps", 5}, {"periods", 7}}));
  EXPECT_EQ(frame_count(fine), 5);
  EXPECT_EQ(step_counts(fine), std::vector{5});
  EXPECT_EQ(highest_frequency(fine), 7);
  EXPECT_TRUE(has_coordinate(plain));
  EXPECT_FALSE(has_coordinate(fine));
  EXPECT_EQ(fine.shape(3, 0.25), 3.25);
  EXPECT_EQ(fine.layout(), (Adjustable{.steps = 5, .periods = 7}.layout()));
}

TEST(Strategy, OwnStrategyIsRefusedWhereItsSettingsOrItsLayoutAreNone) {
  EXPECT_THROW(Strategy(Adjustable{.steps = 2}), Error);
  EXPECT_THROW(Strategy(Adjustable{.periods = -1}), Error);
  EXPECT_THROW(Strategy(Adjustable{.sine_of_constant_light = 0.1}), Error);
  EXPECT_THROW(make_strategy("adjustable", {}), Error) << "the registry does not know it";
}

TEST(Strategy, OwnStrategyIsEqualByNameSettingsAndLayout) {
  EXPECT_EQ(Strategy(Adjustable{}), Strategy(Adjustable{}));
  EXPECT_EQ(Strategy(Adjustable{}), Strategy(Adjustable{.sine_of_constant_light = 0}));
  EXPECT_NE(Strategy(Adjustable{}), Strategy(Adjustable{.steps = 5}));
  EXPECT_NE(Strategy(Adjustable{}), Strategy(Adjustable{.periods = 1})) << "a setting more";
  EXPECT_NE(Strategy(Adjustable{}), Strategy(PhaseMeasuring{.steps = 4}));
  EXPECT_EQ(Strategy(), Strategy(PhaseMeasuring{.steps = 3, .frequency = 1}));
  Strategy copy = CosineSineMean{};
  copy = ThreeFrequencies{};
  EXPECT_EQ(copy, Strategy(ThreeFrequencies{}));
  EXPECT_NE(copy, Strategy(ThreeFrequencies{.first = 36, .second = 6, .third = 1}));
}

TEST(Strategy, OwnStrategyIsShownAsPatterns) {
  constexpr PatternLight light{.alpha_p = 200, .beta_p = 30};
  for (const Strategy& strategy : own_strategies()) {
    Sequence sequence{.strategy = strategy, .axis = Axis::y, .light = light};
    const PatternSet patterns = pattern_set(sequence);
    EXPECT_EQ(patterns.count, frame_count(strategy));
    EXPECT_EQ(patterns.axis, Axis::y);
    for (int n = 0; n < patterns.count; ++n) {
      for (double y = 0; y < 1; y += 0.01) {
        const double expected = 200 * strategy.shape(n, y) + 30;
        EXPECT_NEAR(patterns.intensity(n, y), expected, 1e-12);
        EXPECT_NEAR(pattern_set(strategy, Axis::y, light).intensity(n, y), expected, 1e-12);
      }
    }
    sequence.marker = true;
    EXPECT_EQ(cycle_length(sequence), patterns.count + 1);
    EXPECT_EQ(pattern_set(sequence).count, patterns.count + 1);
    EXPECT_NEAR(pattern_set(sequence).intensity(patterns.count, 0.3), 30, 1e-12) << "dark";
  }
}

TEST(Strategy, OwnStrategyIsRefusedAProjectorThatCannotShowIt) {
  Sequence sequence{.strategy = ThreeFrequencies{}};
  EXPECT_NO_THROW(require_shown(sequence)) << "not known";
  sequence.projector = {72, 800};
  EXPECT_NO_THROW(require_shown(sequence));
  sequence.projector = {71, 800};
  EXPECT_THROW(require_shown(sequence), Error);
  sequence.axis = Axis::y;
  EXPECT_NO_THROW(require_shown(sequence));
}

}  // namespace slipstream::own_strategies_test
