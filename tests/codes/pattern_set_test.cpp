#include "slipstream/pattern_set.h"

#include <cmath>
#include <cstdint>
#include <numbers>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/sequence.h"

namespace slipstream::axis_test {

TEST(PatternSet, AxisNamesAndLengths) {
  EXPECT_EQ(axis_named("x"), Axis::x);
  EXPECT_EQ(axis_named(name_of(Axis::y)), Axis::y);
  EXPECT_THROW(axis_named("z"), Error);
  EXPECT_EQ(length_along(Axis::x, {1824, 1140}), 1824);
  EXPECT_EQ(length_along(Axis::y, {1824, 1140}), 1140);
  EXPECT_DOUBLE_EQ(coordinate_of_pixel(456, 1824), 0.25);
}

}  // namespace slipstream::axis_test

namespace slipstream::pattern_set_test {

using std::numbers::pi;

PatternSet pmp(int N, double f, Axis axis, PatternLight light = {}) {
  return {.count = N, .axis = axis, .light = light, .shape = [=](int n, double y) {
            return sinusoid_intensity({N, f}, n, y);
          }};
}

TEST(PatternSet, IsEquation31) {
  const PatternSet patterns = pmp(5, 7.5, Axis::y, {.alpha_p = 200, .beta_p = 30});
  for (int n = 0; n < 5; ++n) {
    for (const double y : {0.0, 0.1, 0.77}) {
      const double expected = 200 * (0.5 + 0.5 * std::cos(2 * pi * 7.5 * y - 2 * pi * n / 5)) + 30;
      EXPECT_NEAR(patterns.intensity(n, y), expected, 1e-12);
    }
  }
}

TEST(PatternSet, RendersAlongEitherAxisRoundedToGreyLevels) {
  for (const Axis axis : {Axis::x, Axis::y}) {
    for (const int bits : {8, 10, 16}) {
      const PatternSet patterns = pmp(3, 2, axis, {.alpha_p = 250, .beta_p = 5});
      const Size projector{40, 30};
      const Image<std::uint16_t> picture = render_pattern(patterns, 1, projector, bits);
      ASSERT_EQ(picture.size(), projector);
      for (int row = 0; row < 30; ++row) {
        for (int column = 0; column < 40; ++column) {
          const double y = axis == Axis::x ? column / 40.0 : row / 30.0;
          const double exact = patterns.intensity(1, y) * ((1 << bits) - 1) / 255;
          ASSERT_NEAR(picture(column, row), exact, 0.5 + 1e-9);
        }
      }
    }
  }
}

TEST(PatternSet, WithACarrierVariesAcrossItsAxisToo) {
  const PatternSet patterns{.count = 2,
                            .shape =
                                [](int n, double y, double across) {
                                  return 0.5 + 0.3 * std::cos(2 * pi * (2 * y + 3 * across) - n);
                                },
                            .turn = 1,
                            .carrier = true};
  const PatternSet marked = with_marker(patterns);
  const Size projector{40, 30};
  for (int n = 0; n < 2; ++n) {
    const Image<std::uint16_t> picture = render_pattern(patterns, n, projector);
    for (int row = 0; row < 30; ++row) {
      for (int column = 0; column < 40; ++column) {
        const double x = column / 40.0, y = row / 30.0;
        const double exact = n == 0 ? patterns.intensity(0, x, y) : patterns.intensity(1, y, x);
        ASSERT_NEAR(picture(column, row), exact, 0.5 + 1e-9);
      }
    }
    EXPECT_EQ(render_pattern(pattern_alone(patterns, n), 0, projector)(7, 5), picture(7, 5));
    EXPECT_EQ(render_pattern(marked, n, projector)(7, 5), picture(7, 5));
  }
  EXPECT_EQ(render_pattern(marked, 2, projector)(7, 5), 0);
}

TEST(PatternSet, MayTurnToTheOtherAxis) {
  PatternSet patterns{.count = 4, .shape = [](int, double y) { return y; }, .turn = 1};
  for (int n = 0; n < 4; ++n) {
    const Image<std::uint16_t> picture = render_pattern(patterns, n, {16, 8});
    const bool along_x = n % 2 == 0;
    EXPECT_EQ(picture(8, 0) > 0, along_x);
    EXPECT_EQ(picture(0, 4) > 0, !along_x);
    const PatternSet alone = pattern_alone(patterns, n);
    EXPECT_EQ(alone.axis_of(0), along_x ? Axis::x : Axis::y);
    EXPECT_EQ(render_pattern(alone, 0, {16, 8})(8, 0), picture(8, 0));
  }
}

TEST(PatternSet, RefusesWhatNoProjectorShows) {
  EXPECT_THROW(require_valid(PatternLight{.alpha_p = 250, .beta_p = 6}), Error);
  EXPECT_THROW(require_valid(PatternLight{.alpha_p = 0, .beta_p = 0}), Error);
  EXPECT_THROW(require_valid(PatternLight{.alpha_p = std::nan(""), .beta_p = 0}), Error);
  EXPECT_THROW(require_valid(Sinusoid{.steps = 2, .frequency = 1}, "sinusoid"), Error);
  EXPECT_THROW(require_valid(Sinusoid{.steps = 3, .frequency = 0}, "sinusoid"), Error);
  EXPECT_THROW(render_pattern(pmp(3, 1, Axis::x), 3, {4, 4}), Error);
  EXPECT_THROW(render_pattern(pmp(3, 1, Axis::x), 0, {0, 4}), Error);
  EXPECT_THROW(render_pattern(pmp(3, 1, Axis::x), 0, {4, 4}, 17), Error);
}

}  // namespace slipstream::pattern_set_test

namespace slipstream::one_bit_test {

PatternSet binary_sinusoid(double periods, Axis axis, PatternLight light = {}) {
  return {.count = 4,
          .axis = axis,
          .light = light,
          .shape =
              [=](int n, double y) {
                return sinusoid_intensity({4, periods}, n, y);
              },
          .binary = true};
}

TEST(PatternSet, OneBitHoldsTheMeanOfAnyLevel) {
  for (double level = 0; level <= 255; level += 2.5) {
    const Image<double> bits = one_bit(Image<double>({64, 48}, level));
    double sum = 0;
    for (const double bit : bits) {
      ASSERT_TRUE(bit == 0 || bit == 255);
      sum += bit;
    }
    EXPECT_NEAR(sum / static_cast<double>(bits.pixel_count()), level, 0.01 * 255);
  }
}

TEST(PatternSet, OneBitHoldsTheMeanAboutEachPlaceOfAPattern) {
  constexpr int side = 8;
  const PatternSet patterns = binary_sinusoid(5, Axis::x, {.alpha_p = 200, .beta_p = 30});
  PatternSet grey = patterns;
  grey.binary = false;
  const Size projector{320, 240};
  for (int n = 0; n < 4; ++n) {
    const Image<std::uint16_t> bits = render_pattern(patterns, n, projector);
    const Image<std::uint16_t> levels = render_pattern(grey, n, projector);
    for (int top = 0; top + side <= projector.height; top += side) {
      for (int left = 0; left + side <= projector.width; left += side) {
        double difference = 0;
        for (int i = 0; i < side * side; ++i) {
          const int column = left + i % side, row = top + i / side;
          difference += bits(column, row) - levels(column, row);
        }
        EXPECT_NEAR(difference / (side * side), 0, 0.06 * 255) << left << " " << top;
      }
    }
  }
}

TEST(PatternSet, OneBitIsTheSameAlongEitherAxis) {
  const Image<std::uint16_t> upright = render_pattern(binary_sinusoid(3, Axis::x), 1, {60, 40});
  const Image<std::uint16_t> lying = render_pattern(binary_sinusoid(3, Axis::y), 1, {40, 60}, 10);
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 60; ++column) {
      ASSERT_EQ(upright(column, row) * 1023, lying(row, column) * 255);
    }
  }
}

TEST(PatternSet, OneBitKeepsWhatIsDarkOrBrightAlready) {
  const PatternSet stripes{.count = 1,
                           .light = {},
                           .shape = [](int, double y) { return y < 0.3 || y > 0.8 ? 1.0 : 0.0; },
                           .binary = true};
  const Image<std::uint16_t> picture = render_pattern(stripes, 0, {50, 20});
  for (int row = 0; row < 20; ++row) {
    for (int column = 0; column < 50; ++column) {
      EXPECT_EQ(picture(column, row), column < 15 || column > 40 ? 255 : 0);
    }
  }
}

TEST(PatternSet, LengthsInProjectorPixelsHoldAlongBothAxes) {
  const Size projector{1280, 800};
  const Sequence both = default_sequence(
      projector,
      {.strategy = "multi-frequency", .period_pixels = std::vector{1280.0, 80.0}, .axes = "both"});
  for (const Axis axis : {Axis::x, Axis::y}) {
    const double length = length_along(axis, projector);
    const Layout layout = along(both, axis).strategy.layout();
    EXPECT_EQ(layout.bands[0].periods, 1);
    EXPECT_NEAR(layout.bands[1].periods, length / 80, 1e-12);
    EXPECT_EQ(along(along(both, axis), Axis::x), along(both, Axis::x));
  }
  const PatternSet patterns = pattern_set(both);
  const int each = patterns.count / 2;
  for (int n = 0; n < each; ++n) {
    EXPECT_EQ(patterns.axis_of(n + each), Axis::y);
    const PatternSet y = pattern_set(along(both, Axis::y));
    for (const double place : {0.1, 0.37, 0.9}) {
      EXPECT_EQ(patterns.intensity(n + each, place), y.intensity(n, place));
    }
  }
  // Other flags change what was known.
  EXPECT_EQ(changed(both, {.axes = "y"}), along(both, Axis::y));
  EXPECT_TRUE(changed(both, {.settings = {{"periods", "1,16"}}}).lengths.empty());
}

TEST(PatternSet, LengthsOfTheCoarsestMayLackTheLastPixel) {
  const auto bands = [](std::vector<double> lengths) {
    return default_sequence({1280, 800}, {.strategy = "multi-frequency",
                                          .settings = {{"steps", "4"}},
                                          .period_pixels = std::move(lengths)})
        .strategy.layout()
        .bands;
  };
  // Both ends of the field count: np.linspace(0, 2 * np.pi * f, 1280).
  const std::vector<Band> found = bands({1279, 1279.0 / 8, 1279.0 / 64});
  EXPECT_EQ(found[0].periods, 1);
  EXPECT_NEAR(found[1].periods, 8 * 1280 / 1279.0, 1e-12);
  EXPECT_NEAR(found[2].periods, 64 * 1280 / 1279.0, 1e-12);
  EXPECT_NEAR(bands({1270, 160, 20})[0].periods, 1280 / 1270.0, 1e-12);
}

TEST(PatternSet, LengthsOfPeriodsSetTheFrequenciesOfEachStrategy) {
  const auto settings = [](const char* strategy, std::vector<double> lengths) {
    return default_sequence({1920, 1080},
                            {.strategy = strategy, .period_pixels = std::move(lengths)})
        .strategy.settings();
  };
  EXPECT_EQ(settings("pmp", {240}).at("frequency"), SettingValue(8));
  EXPECT_EQ(settings("dual-frequency", {120}).at("high"), SettingValue(16));
  EXPECT_EQ(settings("dual-frequency", {1920, 120}).at("low"), SettingValue(1));
  EXPECT_THROW(settings("gray", {240}), Error);
  EXPECT_THROW(settings("pmp", {240, 24}), Error);

  // A number of periods replaces a length.
  const Sequence known =
      default_sequence({1920, 1080}, {.strategy = "pmp", .period_pixels = std::vector{240.0}});
  const Sequence other = changed(known, {.settings = {{"frequency", "4"}}});
  EXPECT_EQ(other.strategy.settings().at("frequency"), SettingValue(4));
}

/// OpenCV's codes have as many bits as each axis needs; so has a code of periods.
TEST(PatternSet, LengthsMakeACodeAsLongAsItsAxisNeeds) {
  struct Code {
    Size projector;
    SequenceChanges changes;
    int along_x, along_y;
  };
  const SequenceChanges stripes{.strategy = "gray",
                                .settings = {{"reference", "inverse"}},
                                .stripe_pixels = 1,
                                .axes = "both"};
  SequenceChanges fixed = stripes;
  fixed.settings["bits"] = "11";
  const SequenceChanges periods{.strategy = "gray-phase",
                                .settings = {{"steps", "18"}, {"reference", "inverse"}},
                                .period_pixels = std::vector{18.0},
                                .axes = "both"};
  SequenceChanges both = periods;
  both.stripe_pixels = 2;

  for (const auto& [projector, changes, along_x, along_y] :
       {Code{{1280, 800}, stripes, 22, 20}, Code{{1280, 720}, stripes, 22, 20},
        Code{{854, 480}, stripes, 20, 18}, Code{{640, 480}, stripes, 20, 18},
        Code{{912, 1140}, stripes, 20, 22}, Code{{1280, 800}, fixed, 22, 22},
        Code{{1280, 800}, periods, 34, 32}, Code{{1280, 500}, both, 38, 34}}) {
    const Sequence sequence = default_sequence(projector, changes);
    EXPECT_EQ(frames_along_axes(sequence), (std::vector{along_x, along_y}));
    EXPECT_EQ(frame_count(sequence), along_x + along_y);

    const PatternSet patterns = pattern_set(sequence);
    ASSERT_EQ(patterns.count, along_x + along_y);
    const PatternSet y = pattern_set(along(sequence, Axis::y));
    for (int n = 0; n < patterns.count; ++n) {
      EXPECT_EQ(patterns.axis_of(n), n < along_x ? Axis::x : Axis::y);
      if (n >= along_x) EXPECT_EQ(patterns.intensity(n, 0.37), y.intensity(n - along_x, 0.37));
    }
  }
}

}  // namespace slipstream::one_bit_test
