#include "base/moving_mean.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace slipstream::moving_mean_test {

/// The mean over the squares as it is defined.
Image<float> by_definition(const Image<float>& picture, Size window) {
  Image<float> result(picture.size());
  const int beside = window.width / 2, above = window.height / 2;
  for (int row = 0; row < picture.height(); ++row) {
    for (int column = 0; column < picture.width(); ++column) {
      double sum = 0;
      int count = 0;
      for (int y = std::max(row - above, 0); y <= std::min(row + above, picture.height() - 1);
           ++y) {
        for (int x = std::max(column - beside, 0);
             x <= std::min(column + beside, picture.width() - 1); ++x) {
          sum += picture(x, y);
          ++count;
        }
      }
      result(column, row) = static_cast<float>(sum / count);
    }
  }
  return result;
}

TEST(MovingMean, IsThreeMeansOverAWindow) {
  for (const Size size : {Size{1, 1}, {5, 3}, {70, 19}, {131, 90}}) {
    Image<float> picture(size);
    for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
      picture.begin()[i] =
          static_cast<float>(100 + 99 * std::sin(0.37 * static_cast<double>(i * i)));
    }
    for (const Size window : {Size{1, 1}, {3, 5}, {15, 3}, {201, 7}}) {
      Image<float> expected = picture, taken = picture, scratch;
      for (int pass = 0; pass < 3; ++pass) expected = by_definition(expected, window);
      take_moving_mean(taken, window, scratch);
      for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
        ASSERT_NEAR(taken.begin()[i], expected.begin()[i], 2e-3)
            << size.width << " " << window.width;
      }
    }
  }
}

TEST(MovingMean, LetsNothingPassThatRepeatsAfterItsLength) {
  constexpr int length = 15;
  Image<float> picture({120, 80}), scratch;
  for (int row = 0; row < picture.height(); ++row) {
    for (int column = 0; column < picture.width(); ++column) {
      picture(column, row) =
          static_cast<float>(100 * std::cos(2 * std::numbers::pi * column / length));
    }
  }
  take_moving_mean(picture, {length, 1}, scratch);
  for (int column = 2 * length; column < picture.width() - 2 * length; ++column) {
    EXPECT_NEAR(picture(column, 40), 0, 0.02);
  }
}

TEST(MovingMean, OddLengthIsNextToTheOneAskedFor) {
  EXPECT_EQ(odd_length(14.2), 15);
  EXPECT_EQ(odd_length(13.9), 13);
  EXPECT_EQ(odd_length(0.3), 1);
  EXPECT_EQ(odd_length(INFINITY) % 2, 1);
}

}  // namespace slipstream::moving_mean_test
