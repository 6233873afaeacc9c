#include "slipstream/geometry/ray_table.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/geometry/random_scanner.h"

namespace slipstream::ray_table_test {

double worst_miss(const Lens& camera, const RayTable& table) {
  double worst = 0;
  const auto next = [](int i, int length) {
    return i + 3 < length ? i + 3 : std::max(i + 1, length - 1);
  };
  for (int row = 0; row < camera.size.height; row = next(row, camera.size.height)) {
    for (int column = 0; column < camera.size.width; column = next(column, camera.size.width)) {
      const Eigen::Vector3d ray = ray_through(camera, {column, row});
      worst = std::max({worst, std::abs(table.E_x(column, row) - ray.x()),
                        std::abs(table.E_y(column, row) - ray.y())});
    }
  }
  return worst;
}

TEST(RayTable, HoldsTheRays) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Lens camera = random_scanner(seed, 0.12).camera;
    for (const Size size : {Size{640, 480}, Size{643, 477}, Size{641, 481}, Size{33, 25},
                            Size{40, 31}, Size{16, 1}}) {
      camera.size = size;
      const auto table = ray_table(camera);
      ASSERT_TRUE(table);
      EXPECT_LE(worst_miss(camera, *table), 2e-7) << "scanner " << seed << ", " << size.width;
    }
  }
}

TEST(RayTable, HoldsTheRaysOfALensThatBendsMuch) {
  Lens camera;
  camera.size = {160, 120};
  camera.intrinsic << 80, 0, 80, 0, 80, 60, 0, 0, 1;
  camera.distortion = make_distortion(std::array{-0.1, 0.02, 1e-3, -1e-3, 0.0});
  const auto table = ray_table(camera);
  ASSERT_TRUE(table);
  EXPECT_LE(worst_miss(camera, *table), 2e-7);
}

TEST(RayTable, IsNoneWhereAPixelHasNoRay) {
  Lens camera;
  camera.size = {160, 120};
  camera.intrinsic << 80, 0, 80, 0, 80, 60, 0, 0, 1;
  camera.distortion = make_distortion(std::array{-0.5, 0.0, 0.0, 0.0});
  EXPECT_FALSE(ray_table(camera));
}

}  // namespace slipstream::ray_table_test
