#include "slipstream/codes/one_bit.h"

#include <cstdint>

#include <gtest/gtest.h>

#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/sinusoid.h"

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

TEST(OneBit, HoldsTheMeanOfAnyLevel) {
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

TEST(OneBit, HoldsTheMeanAboutEachPlaceOfAPattern) {
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

TEST(OneBit, IsTheSameAlongEitherAxis) {
  const Image<std::uint16_t> upright = render_pattern(binary_sinusoid(3, Axis::x), 1, {60, 40});
  const Image<std::uint16_t> lying = render_pattern(binary_sinusoid(3, Axis::y), 1, {40, 60}, 10);
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 60; ++column) {
      ASSERT_EQ(upright(column, row) * 1023, lying(row, column) * 255);
    }
  }
}

TEST(OneBit, KeepsWhatIsDarkOrBrightAlready) {
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

}  // namespace slipstream::one_bit_test
