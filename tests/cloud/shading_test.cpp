// How bright surfaces of a known slope look.
#include "slipstream/cloud/shading.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace slipstream::shading_test {

/// A plane before a camera whose focal length is 200 pixels, as noisy in depth as is asked for, mm.
Cloud sloping(float slope, float noise = 0) {
  Cloud cloud({64, 48});
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  for (int row = 0; row < 48; ++row) {
    for (int column = 0; column < 64; ++column) {
      const float u = (static_cast<float>(column) - 32) / 200;
      const float v = (static_cast<float>(row) - 24) / 200;
      const float z = 500 / (1 - slope * u) + noise * normal(random);
      cloud.x(column, row) = u * z;
      cloud.y(column, row) = v * z;
      cloud.z(column, row) = z;
      cloud.validity(column, row) = Validity::valid;
    }
  }
  return cloud;
}

/// Of a plane z = z0 + slope x, under the light.
float expected(float slope) {
  const float length = std::sqrt(0.16F + 0.25F + 1);
  return 0.3F + 0.7F * (1 - 0.4F * slope) / (length * std::sqrt(1 + slope * slope));
}

TEST(Shading, IsThatOfThePlanesNormal) {
  for (const float slope : {-0.5F, 0.0F, 0.5F}) {
    EXPECT_NEAR(shading(sloping(slope))(32, 24), expected(slope), 1e-3) << slope;
  }
}

TEST(Shading, HidesTheNoiseOfDepth) {
  const Image<float> brightness = shading(sloping(0, 0.4F));
  double sum = 0;
  for (int row = 4; row < 44; ++row) {
    for (int column = 4; column < 60; ++column) {
      sum += std::pow(brightness(column, row) - expected(0), 2);
    }
  }
  // A pixel is 2.5 mm wide: slopes from one to the next are off by 0.2.
  EXPECT_LT(std::sqrt(sum / (40 * 56)), 0.04);
}

TEST(Shading, IsInBetweenWhereTheSlopeIsNotKnown) {
  Cloud cloud = sloping(0);
  std::fill(cloud.z.begin(), cloud.z.end(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_FLOAT_EQ(shading(cloud)(10, 10), 0.82F);
}

}  // namespace slipstream::shading_test
