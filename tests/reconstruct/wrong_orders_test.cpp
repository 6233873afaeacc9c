// How often noise makes a fringe order wrong, against what `design` promises.
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "codes/design.h"
#include "decode/decoder.h"
#include "slipstream/frame_set.h"
#include "slipstream/strategy.h"
#include "slipstream/unwrapping.h"

namespace slipstream::wrong_orders_test {

constexpr double alpha = 0.5;

/// The noise under which that share of the orders is predicted to be right.
double noise_for(const Layout& layout, double success) {
  double low = 1e-6, high = 1e6;
  while (high / low > 1 + 1e-9) {
    const double middle = std::sqrt(low * high);
    (predicted_success(layout, alpha, middle) > success ? low : high) = middle;
  }
  return low;
}

/// Share of the pixels of a noisy picture of the whole field that are at a wrong fringe order.
double wrong_share(const Strategy& strategy, double noise_variance, Size size) {
  const PatternSet patterns = pattern_set(strategy, Axis::x);
  std::mt19937_64 random(11);
  std::normal_distribution<double> w(0, std::sqrt(noise_variance));
  const auto coordinate = [&](int column) { return (column + 0.5) / size.width; };
  FrameSet::ImagesUnquantised images;
  for (int n = 0; n < patterns.count; ++n) {
    Image<double>& image = images.emplace_back(size);
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        image(column, row) = alpha * patterns.intensity(n, coordinate(column)) + w(random);
      }
    }
  }
  const Decoder decode(strategy.layout(), size.width, PhaseMethod::equation);
  const BasicMaps<double> maps = decode(FrameSet(std::move(images)));
  const bool ends_meet = is_circle(strategy.layout());
  double wrong = 0;
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const double error = maps.coordinate(column, row) - coordinate(column);
      const double apart = ends_meet ? std::remainder(error, 1) : error;
      wrong += std::abs(apart) * highest_frequency(strategy) < 0.5 ? 0 : 1;
    }
  }
  return wrong / static_cast<double>(size.width) / size.height;
}

TEST(WrongOrders, AreAsManyAsPredicted) {
  constexpr Size size{1000, 400};
  constexpr double pixels = size.width * size.height;
  for (const Strategy& strategy :
       {Strategy(DualFrequency{.steps = 3, .low_steps = 4, .high = 20}),
        Strategy(MultiFrequency{.steps = {3, 4, 3}, .periods = {1, 15, 240}}),
        Strategy(MultiFrequency{.steps = {3}, .periods = {81, 80, 72}, .unwrapping = "heterodyne"}),
        Strategy(MultiFrequency{.steps = {3}, .periods = {13, 15}, .unwrapping = "number-theory"}),
        Strategy(MultiFrequency{
            .steps = {4, 3, 3}, .periods = {19, 23, 21}, .unwrapping = "number-theory"})}) {
    for (const double wrong : {0.03, 0.003}) {
      const double noise_variance = noise_for(strategy.layout(), 1 - wrong);
      const double counted = wrong_share(strategy, noise_variance, size);
      EXPECT_NEAR(counted, wrong, 4 * std::sqrt(wrong * (1 - wrong) / pixels))
          << label_of(strategy);
    }
  }
}

}  // namespace slipstream::wrong_orders_test
