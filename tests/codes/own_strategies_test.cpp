// A struct that declares a coding is a strategy.
#include "tests/own_strategies.h"

#include <optional>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/registry.h"
#include "slipstream/codes/sequence.h"

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

TEST(OwnStrategy, SaysWhatItsStructSays) {
  const Strategy plain = Adjustable{}, fine = Adjustable{.steps = 5, .periods = 7};
  EXPECT_EQ(plain.name(), "adjustable");
  EXPECT_EQ(name_of(plain), "adjustable");
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

TEST(OwnStrategy, IsRefusedWhereItsSettingsOrItsLayoutAreNone) {
  EXPECT_THROW(Strategy(Adjustable{.steps = 2}), Error);
  EXPECT_THROW(Strategy(Adjustable{.periods = -1}), Error);
  EXPECT_THROW(Strategy(Adjustable{.sine_of_constant_light = 0.1}), Error);
  EXPECT_THROW(make_strategy("adjustable", {}), Error) << "the registry does not know it";
}

TEST(OwnStrategy, IsEqualByNameSettingsAndLayout) {
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

TEST(OwnStrategy, IsShownAsPatterns) {
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

TEST(OwnStrategy, IsRefusedAProjectorThatCannotShowIt) {
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
