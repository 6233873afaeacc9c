#include "slipstream/codes/pattern_set.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/sinusoid.h"

namespace slipstream::pattern_set_test {

using std::numbers::pi;

PatternSet pmp(int N, double f, Axis axis, PatternLight light = {}) {
  return {.count = N, .axis = axis, .light = light, .shape = [=](int n, double y) {
            return sinusoid_intensity({N, f}, n, y);
          }};
}

TEST(Pattern, IsEquation31) {
  const PatternSet patterns = pmp(5, 7.5, Axis::y, {.alpha_p = 200, .beta_p = 30});
  for (int n = 0; n < 5; ++n) {
    for (const double y : {0.0, 0.1, 0.77}) {
      const double expected = 200 * (0.5 + 0.5 * std::cos(2 * pi * 7.5 * y - 2 * pi * n / 5)) + 30;
      EXPECT_NEAR(patterns.intensity(n, y), expected, 1e-12);
    }
  }
}

TEST(Pattern, RendersAlongEitherAxisRoundedToGreyLevels) {
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

TEST(Pattern, WithACarrierVariesAcrossItsAxisToo) {
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

TEST(Pattern, MayTurnToTheOtherAxis) {
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

TEST(Pattern, RefusesWhatNoProjectorShows) {
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
