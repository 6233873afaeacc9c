#include "slipstream/response/ambient_measurement.h"

#include <cmath>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"

namespace slipstream::ambient_measurement_test {

constexpr PatternLight light{.alpha_p = 200, .beta_p = 55};

TEST(AmbientMeasurement, SolvesEquation35AtBrightPixels) {
  const Size size{40, 30};
  Image<double> mean(size), modulation(size);
  Image<std::uint8_t> measured(size, 1);
  measured(3, 4) = 0;
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const double alpha = (column + 1.0) / size.width;
      const double beta = row == 0 ? 30 : -7;               // a row that sees a lamp
      modulation(column, row) = alpha * light.alpha_p / 2;  // (3.4)
      mean(column, row) = alpha * (light.alpha_p / 2 + light.beta_p + beta) + beta;  // (3.3)
    }
  }
  const Image<double> map = ambient_map(mean, modulation, light, 0.5, measured);
  EXPECT_TRUE(std::isnan(map(3, 4)));
  EXPECT_TRUE(std::isnan(map(10, 4)));
  EXPECT_NEAR(map(35, 4), -7, 1e-12);
  const AmbientEstimate estimate = ambient_estimate(map);
  EXPECT_NEAR(estimate.mode, -7, 1e-12);
  EXPECT_NEAR(estimate.median, -7, 1e-12);
  EXPECT_NEAR(estimate.mean, -7 + 37.0 / 30, 1e-9) << "the lamp draws the mean, not the mode";
  EXPECT_EQ(estimate.pixels, 21U * 30U);
  EXPECT_THROW(ambient_estimate(ambient_map(mean, modulation, light, 1, measured)), Error);
}

}  // namespace slipstream::ambient_measurement_test
