#include "slipstream/cloud/cloud.h"

#include <cmath>

#include <gtest/gtest.h>

#include "slipstream/cloud/normals.h"

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

TEST(SurfaceNormals, AreThoseOfAPlane) {
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

TEST(SurfaceNormals, DoNotReachAcrossADepthEdge) {
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

TEST(SurfaceNormals, DoNotReachAcrossADepthEdgeOffTheAxis) {
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

}  // namespace slipstream::cloud_test
