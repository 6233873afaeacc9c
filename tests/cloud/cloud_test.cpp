// How bright surfaces of a known slope look.
#include "slipstream/cloud.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "slipstream/surface.h"

namespace slipstream::cloud_test {

/// A plane through (0, 0, 500) seen by a pinhole camera.
Cloud plane(const Size size, double slope_x, double slope_y) {
  Cloud cloud(size);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const double u = (column - 20) / 100.0, v = (row - 15) / 100.0;
      const double z = 500 / (1 - slope_x * u - slope_y * v);
      cloud.x(column, row) = static_cast<float>(u * z);
      cloud.y(column, row) = static_cast<float>(v * z);
      cloud.z(column, row) = static_cast<float>(z);
      cloud.validity(column, row) = Validity::valid;
    }
  }
  return cloud;
}

TEST(Cloud, StartsWithoutPointsAndCountsThem) {
  Cloud cloud({4, 2});
  EXPECT_EQ(point_count(cloud), 0U);
  EXPECT_TRUE(std::isnan(cloud.z(3, 1)));
  cloud.validity(0, 0) = Validity::valid;
  cloud.validity(1, 0) = Validity::too_dark;
  EXPECT_EQ(point_count(cloud), 1U);
  EXPECT_EQ(count_by_validity(cloud)[1], 1U);
  EXPECT_EQ(name_of(Validity::too_dark), "too dark");
}

TEST(Cloud, SurfaceNormalsAreThoseOfAPlane) {
  const Normals normals = surface_normals(plane({40, 30}, 0.3, -0.2));
  const double length = std::sqrt(0.3 * 0.3 + 0.2 * 0.2 + 1);
  for (int row = 0; row < 30; ++row) {
    for (int column = 0; column < 40; ++column) {
      ASSERT_NEAR(normals.x(column, row), 0.3 / length, 1e-5);
      ASSERT_NEAR(normals.y(column, row), -0.2 / length, 1e-5);
      ASSERT_NEAR(normals.z(column, row), -1 / length, 1e-5);
    }
  }
}

TEST(Cloud, SurfaceNormalsDoNotReachAcrossADepthEdge) {
  Cloud cloud = plane({40, 30}, 0, 0);
  for (int row = 0; row < 30; ++row) {
    for (int column = 20; column < 40; ++column) {
      cloud.x(column, row) *= 1.5F;
      cloud.y(column, row) *= 1.5F;
      cloud.z(column, row) *= 1.5F;
    }
  }
  const Normals normals = surface_normals(cloud);
  EXPECT_NEAR(normals.z(19, 10), -1, 1e-5);
  EXPECT_NEAR(normals.z(20, 10), -1, 1e-5);
}

TEST(Cloud, SurfaceNormalsDoNotReachAcrossADepthEdgeOffTheAxis) {
  Cloud cloud({40, 30});
  for (int row = 0; row < 30; ++row) {
    for (int column = 0; column < 40; ++column) {
      const float z = column < 20 ? 500 : 1000;
      cloud.x(column, row) = (0.3F + static_cast<float>(column) / 800) * z;
      cloud.y(column, row) = static_cast<float>(row) / 800 * z;
      cloud.z(column, row) = z;
    }
  }
  const Normals normals = surface_normals(cloud);
  EXPECT_NEAR(normals.z(19, 10), -1, 1e-5);
  EXPECT_NEAR(normals.z(20, 10), -1, 1e-5);
}

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

TEST(Cloud, ShadingIsThatOfThePlanesNormal) {
  for (const float slope : {-0.5F, 0.0F, 0.5F}) {
    EXPECT_NEAR(shading(sloping(slope))(32, 24), expected(slope), 1e-3) << slope;
  }
}

TEST(Cloud, ShadingOfAListOfPointsIsThatOfTheirPicture) {
  for (const float slope : {-0.5F, 0.0F, 0.5F}) {
    const Cloud plane = sloping(slope);
    Cloud list({64 * 48, 1});
    std::copy(plane.x.begin(), plane.x.end(), list.x.begin());
    std::copy(plane.y.begin(), plane.y.end(), list.y.begin());
    std::copy(plane.z.begin(), plane.z.end(), list.z.begin());
    const Image<float> brightness = shading(list);
    double sum = 0;
    for (const float value : brightness) sum += std::abs(value - expected(slope));
    EXPECT_LT(sum / (64 * 48), 0.01) << slope;
  }
}

TEST(Cloud, ShadingOfAListThatShowsNoSurfaceIsInBetween) {
  Cloud line({100, 1});
  EXPECT_FLOAT_EQ(shading(line)(50, 0), 0.82F);
  std::fill(line.z.begin(), line.z.end(), -5.0F);
  EXPECT_FLOAT_EQ(shading(line)(50, 0), 0.82F);
  // All but on a line: pixels as small as their distance from it would not fit into memory.
  for (int n = 0; n < 100; ++n) {
    line.x(n, 0) = 1e6F * static_cast<float>(n);
    line.y(n, 0) = n % 2 == 0 ? 0.0F : 1e-30F;
    line.z(n, 0) = 1;
  }
  EXPECT_FLOAT_EQ(shading(line)(50, 0), 0.82F);
  line.z(3, 0) = std::numeric_limits<float>::denorm_min();  // a ray of infinite slope
  line.x(7, 0) = std::numeric_limits<float>::quiet_NaN();
  line.y(9, 0) = std::numeric_limits<float>::infinity();
  EXPECT_FLOAT_EQ(shading(line)(50, 0), 0.82F);
}

TEST(Cloud, ShadingHidesTheNoiseOfDepth) {
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

TEST(Cloud, ShadingFadesWhereNoiseLeavesNoSlope) {
  // A pixel is 2.5 mm wide: with 20 mm of noise, normals point every way.
  const Image<float> brightness = shading(sloping(0, 20));
  double sum = 0;
  for (int row = 4; row < 44; ++row) {
    for (int column = 4; column < 60; ++column) {
      sum += std::pow(brightness(column, row) - 0.82, 2);
    }
  }
  EXPECT_LT(std::sqrt(sum / (40 * 56)), 0.05);
}

TEST(Cloud, ShadingIsInBetweenWhereTheSlopeIsNotKnown) {
  Cloud cloud = sloping(0);
  std::fill(cloud.z.begin(), cloud.z.end(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_FLOAT_EQ(shading(cloud)(10, 10), 0.82F);
}

}  // namespace slipstream::cloud_test
