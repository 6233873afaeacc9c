#include "slipstream/cloud/spheres.h"

#include <array>
#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/io/expect_error.h"
#include "tests/simulate/cast_cloud.h"

namespace slipstream::spheres_test {

using Eigen::Vector3d;

Body placed(Shape shape, const Vector3d& place, double tilt = 0) {
  return {.shape = std::move(shape),
          .pose = Eigen::Translation3d(place) * Eigen::AngleAxisd(tilt, Vector3d::UnitY())};
}

RC_GTEST_PROP(FindSpheres, FindsTwoAmongPlanesAndBoxesUnderNoise, (unsigned seed)) {
  const auto between = [](int low, int high) { return 1.0 * *rc::gen::inRange(low, high); };
  const std::array radii{between(12, 30), between(12, 30)};
  const Vector3d left(between(-85, -50), between(-40, 40), between(530, 680));
  const Vector3d right(between(50, 85), between(-40, 40), between(530, 680));
  const Scene scene{sphere_at(left, radii[0]), sphere_at(right, radii[1]),
                    placed(Box{{30, 40, 30}}, {0, 20, 600}, 0.5),
                    placed(Board{800, 800}, {0, 0, 720}, 0.2)};
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 0.1);
  const Cloud cloud = cast_cloud(scene, {320, 240}, [&](int, int) { return noise(random); });
  const std::vector<FittedSphere> found = find_spheres(cloud, radii);
  RC_ASSERT(found.size() == 2U);
  const bool swapped = (found[0].centre - left).norm() > 10;  // of one size either may be first
  RC_ASSERT(!swapped || std::abs(radii[0] - radii[1]) < 0.5);
  RC_ASSERT((found[swapped ? 1 : 0].centre - left).norm() < 0.3);
  RC_ASSERT((found[swapped ? 0 : 1].centre - right).norm() < 0.3);
  for (std::size_t i = 0; i < 2; ++i) RC_ASSERT(std::abs(found[i].radius - radii[i]) < 0.3);
}

TEST(FindSpheres, LeavesToEachOfNearlyOneSizeItsOwn) {
  const Vector3d left(-63, -39, 530), right(50, -40, 530);
  const Cloud cloud = cast_cloud({sphere_at(left, 21), sphere_at(right, 19)});
  for (const std::array radii : {std::array{21.0, 19.0}, std::array{19.0, 21.0}}) {
    const std::vector<FittedSphere> found = find_spheres(cloud, radii);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_LT((found[i].centre - (radii[i] == 21 ? left : right)).norm(), 0.01);
    }
  }
}

TEST(FindSpheres, RefusesWhereThereIsNone) {
  const Scene scene{placed(Board{800, 800}, {0, 0, 650}, 0.3), sphere_at({0, 0, 600}, 30)};
  const Cloud cloud = cast_cloud(scene);
  const auto expect_refused = [&](const std::vector<double>& radii,
                                  std::initializer_list<std::string> parts) {
    expect_error([&] { (void)find_spheres(cloud, radii); }, parts);
  };
  EXPECT_EQ(find_spheres(cloud, std::array{30.0}).size(), 1U);
  expect_refused({20}, {"no sphere of diameter 40 mm"});
  expect_refused({60}, {"no sphere of diameter 120 mm"});
  expect_refused({30, 30}, {"60 mm", "beside the first"});
  expect_error([&] { (void)find_spheres(Cloud({0, 0}), std::array{30.0}); }, {"60 mm"});
}

TEST(IsOnCap, AsksTheRayAndNotTheDistance) {
  const FittedSphere sphere{.centre = {0, 0, 600}, .radius = 30, .residuals = {}};
  for (const MeasuredPoint& point :
       points_in(cast_cloud({sphere_at({0, 0, 600}, 30)}), nullptr, {0, 0, {320, 240}})) {
    const Vector3d inwards = (sphere.centre - point.position).normalized();
    const double angle = std::acos(inwards.dot(point.position.normalized()));
    EXPECT_TRUE(is_on_cap(sphere, point.position, angle + 1e-3));
    EXPECT_FALSE(is_on_cap(sphere, 2 * point.position, angle - 1e-3));
  }
}

}  // namespace slipstream::spheres_test
