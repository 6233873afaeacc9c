#include "slipstream/measure.h"

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/virtual_scanner.h"
#include "tests/io/expect_error.h"
#include "tests/simulate/cast_cloud.h"

namespace slipstream::measure_test {

using Points = std::vector<MeasuredPoint>;
using Eigen::Vector3d;

/// Points of a patch 100 mm wide about (0, 0, 600), at depth(x, y), with noise along z.
template <class Depth>
Points patch(const Depth& depth, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> gaussian(0, noise);
  Points points;
  for (int x = -50; x < 50; x += 2) {
    for (int y = -50; y < 50; y += 2) {
      points.push_back({Vector3d(x, y, depth(x, y) + gaussian(random)), std::nullopt});
    }
  }
  return points;
}

RC_GTEST_PROP(MeasureFitPlane, FindsThePlaneUnderNoiseAndAThirdOfOutliers, (unsigned seed)) {
  const double slope_x = 0.01 * *rc::gen::inRange(-80, 80);
  const double slope_y = 0.01 * *rc::gen::inRange(-80, 80);
  const int third = *rc::gen::inRange(3, 20);
  Points points =
      patch([&](double x, double y) { return 600 + slope_x * x + slope_y * y; }, 0.05, seed);
  std::mt19937 random(seed);
  std::size_t spoilt = 0;
  for (std::size_t i = 0; i < points.size(); i += static_cast<std::size_t>(third), ++spoilt) {
    points[i].position.z() -= 5 + random() % 100;
  }
  const FittedPlane plane = fit_plane(points);
  const Vector3d truth = Vector3d(slope_x, slope_y, -1).normalized();
  RC_ASSERT((plane.normal - truth).norm() < 5e-4);
  RC_ASSERT(std::abs(truth.dot(plane.centre - Vector3d(0, 0, 600))) < 0.02);
  RC_ASSERT(plane.residuals.outliers >= spoilt);
  RC_ASSERT(plane.residuals.outliers < spoilt + 15);
  RC_ASSERT(std::abs(plane.residuals.rms / (0.05 * -truth.z()) - 1) < 0.1);
  // Four robust standard deviations, which are themselves known to a tenth or so.
  RC_ASSERT(plane.residuals.largest < 5 * 0.05);
  RC_ASSERT(!plane.residuals.noise);
}

RC_GTEST_PROP(MeasureFitSphere, FindsTheRadiusUnderNoiseAndAThirdOfOutliers, (unsigned seed)) {
  const double radius = *rc::gen::inRange(75, 200);
  const int third = *rc::gen::inRange(3, 20);
  const auto depth = [&](double x, double y) {
    return 600 + radius - std::sqrt(radius * radius - x * x - y * y);
  };
  Points points = patch(depth, 0.02, seed);
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < points.size(); i += static_cast<std::size_t>(third)) {
    points[i].position.z() += 3 + random() % 100;
  }
  const FittedSphere sphere = fit_sphere(points);
  RC_ASSERT(std::abs(sphere.radius - radius) < 6 * sphere.radius_sigma);
  RC_ASSERT(sphere.radius_sigma < 0.05);
  RC_ASSERT((sphere.centre - Vector3d(0, 0, 600 + radius)).norm() < 0.3);
  RC_ASSERT(sphere.residuals.rms < 0.022);
}

TEST(MeasureFitPlane, IsExactWithoutNoise) {
  const FittedPlane plane = fit_plane(patch([](double x, double) { return 600 + 0.5 * x; }, 0, 1));
  EXPECT_EQ(plane.residuals.outliers, 0U);
  EXPECT_LT(plane.residuals.largest, 1e-9);
  EXPECT_LT((plane.normal - Vector3d(0.5, 0, -1).normalized()).norm(), 1e-12);
}

/// What a fit throws.
template <class Fit>
std::string error_of(const Fit& fit, const Points& points) {
  try {
    static_cast<void>(fit(points));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Measure, FitsRefusePointsThatMakeOutNoShape) {
  Points line;
  for (int i = 0; i < 50; ++i) line.push_back({Vector3d(i, 2.0 * i, 500), std::nullopt});
  const auto flat = patch([](double x, double) { return 600 + 0.1 * x; }, 0.01, 3);
  const auto plane = [](const Points& points) { return fit_plane(points); };
  const auto sphere = [](const Points& points) { return fit_sphere(points); };
  EXPECT_NE(error_of(plane, line).find("line"), std::string::npos);
  EXPECT_NE(error_of(plane, {line[0], line[1]}).find("too few"), std::string::npos);
  EXPECT_NE(error_of(sphere, flat).find("too flat"), std::string::npos);
  EXPECT_NE(error_of(sphere, {flat[0], flat[1], flat[2]}).find("too few"), std::string::npos);
  EXPECT_NE(error_of(sphere, Points(10, flat[0])), "");
  EXPECT_NE(error_of(sphere, line), "");
  EXPECT_NE(error_of(plane, Points(10, flat[0])).find("line"), std::string::npos);
}

RC_GTEST_PROP(MeasureFitSphere, RefusesAFlatPatch, (unsigned seed)) {
  const double noise = 0.001 * *rc::gen::inRange(1, 500);
  const auto sphere = [](const Points& points) { return fit_sphere(points); };
  const std::string error = error_of(
      sphere, patch([](double x, double y) { return 600 - 0.4 * x - 0.2 * y; }, noise, seed));
  RC_ASSERT(error.find("too flat") != std::string::npos);
}

TEST(Measure, DistanceErrsAlongTheRaysOfBothPoints) {
  // On the axis noise moves a point along z alone, which an upright distance does not feel.
  const MeasuredPoint near{{0, 0, 500}, Vector3d(0, 0, 0.3)}, far{{0, 0, 600}, Vector3d(0, 0, 0.4)};
  const Distance along = distance(near, far);
  EXPECT_DOUBLE_EQ(along.length, 100);
  EXPECT_NEAR(along.sigma.value(), 0.5, 1e-12);
  const MeasuredPoint left{{-100, 0, 500}, Vector3d(0.06, 0, 0.3)},
      right{{100, 0, 500}, Vector3d(0.06, 0, 0.3)};
  EXPECT_NEAR(distance(left, right).sigma.value(), 0.06 * std::sqrt(2), 1e-12);
  EXPECT_FALSE(distance(near, {{0, 0, 1}, std::nullopt}).sigma);
}

TEST(Measure, PointAtKnowsNothingOfOtherPixels) {
  Cloud cloud({4, 3});
  cloud.x(1, 2) = 5;
  cloud.y(1, 2) = 6;
  cloud.z(1, 2) = 700;
  cloud.validity(1, 2) = Validity::valid;
  Uncertainty sigma(cloud.size());
  EXPECT_EQ(point_at(cloud, nullptr, 1, 2)->position, Vector3d(5, 6, 700));
  EXPECT_FALSE(point_at(cloud, &sigma, 1, 2)->sigma);
  sigma.x(1, 2) = sigma.y(1, 2) = sigma.z(1, 2) = 0.5F;
  EXPECT_EQ(point_at(cloud, &sigma, 1, 2)->sigma, Vector3d(0.5, 0.5, 0.5));
  EXPECT_FALSE(point_at(cloud, nullptr, 0, 0));
  EXPECT_FALSE(point_at(cloud, nullptr, 4, 0));
  EXPECT_FALSE(point_at(cloud, nullptr, 0, -1));
  EXPECT_EQ(points_in(cloud, nullptr, Rectangle{1, 1, {99, 99}}).size(), 1U);
  EXPECT_EQ(points_in(cloud, nullptr, Rectangle{2, 0, {99, 99}}).size(), 0U);
  constexpr int most = std::numeric_limits<int>::max();
  EXPECT_EQ(points_in(cloud, nullptr, Rectangle{1, 2, {most, most}}).size(), 1U);
  EXPECT_EQ(points_in(cloud, nullptr, Rectangle{most, most, {most, most}}).size(), 0U);
}

/// A scene of the virtual scanner with noise, as a cloud with its uncertainty.
struct MeasuredScene {
  Cloud cloud;
  Uncertainty sigma;
};

MeasuredScene measured(const char* scene) {
  constexpr PatternLight light{.alpha_p = 200, .beta_p = 40};
  const Photometry photometry{.ambient = 4, .noise_variance = 1.55, .bits = 8};
  Scanner scanner = example_scanner({320, 240});
  const Strategy strategy = DualFrequency{.steps = 4, .high = 16, .low = 1};
  const VirtualScan scan = take_scan(scanner, scene_named(scene, scanner),
                                     pattern_set(strategy, Axis::x, light), photometry);
  scanner.photometry = {.ambient = photometry.ambient, .noise_variance = 1.55 + 1.0 / 12};
  Engine engine(scanner, {.strategy = strategy, .light = light});
  MeasuredScene result{Cloud(scan.depth.size()), Uncertainty()};
  Maps maps;
  engine.cloud_and_maps(scan.frames, result.cloud, maps);
  result.sigma = engine.uncertainty(result.cloud, maps, scan.frames);
  return result;
}

TEST(Measure, VirtualBoardItsResidualIsThatOfTheNoise) {
  const MeasuredScene board = measured("board");
  const Residuals residuals =
      fit_plane(points_in(board.cloud, &board.sigma, Rectangle{60, 40, {200, 160}})).residuals;
  EXPECT_GT(residuals.points, 31000U);
  ASSERT_TRUE(residuals.noise);
  EXPECT_NEAR(residuals.rms / *residuals.noise, 1, 0.05);
}

TEST(Measure, VirtualSphereHasItsRadius) {
  const Scanner scanner = example_scanner({320, 240});
  const double radius = std::get<Sphere>(scene_named("sphere", scanner).front().shape).radius;
  const MeasuredScene scene = measured("sphere");
  const FittedSphere sphere =
      fit_sphere(points_in(scene.cloud, &scene.sigma, Rectangle{110, 70, {100, 100}}));
  EXPECT_NEAR(sphere.radius, radius, 5 * sphere.radius_sigma);
  EXPECT_LT(sphere.radius_sigma, 1e-3 * radius);
  EXPECT_NEAR(sphere.residuals.rms / sphere.residuals.noise.value(), 1, 0.1);
}

Body placed(Shape shape, const Vector3d& place, double tilt = 0) {
  return {.shape = std::move(shape),
          .pose = Eigen::Translation3d(place) * Eigen::AngleAxisd(tilt, Vector3d::UnitY())};
}

RC_GTEST_PROP(MeasureFindSpheres, FindsTwoAmongPlanesAndBoxesUnderNoise, (unsigned seed)) {
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

TEST(MeasureFindSpheres, LeavesToEachOfNearlyOneSizeItsOwn) {
  const Vector3d left(-63, -39, 530), right(50, -40, 530);
  const Cloud cloud = cast_cloud({sphere_at(left, 21), sphere_at(right, 19)});
  for (const std::array radii : {std::array{21.0, 19.0}, std::array{19.0, 21.0}}) {
    const std::vector<FittedSphere> found = find_spheres(cloud, radii);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_LT((found[i].centre - (radii[i] == 21 ? left : right)).norm(), 0.01);
    }
  }
}

TEST(MeasureFindSpheres, RefusesWhereThereIsNone) {
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

TEST(Measure, IsOnCapAsksTheRayAndNotTheDistance) {
  const FittedSphere sphere{.centre = {0, 0, 600}, .radius = 30, .residuals = {}};
  for (const MeasuredPoint& point :
       points_in(cast_cloud({sphere_at({0, 0, 600}, 30)}), nullptr, Rectangle{0, 0, {320, 240}})) {
    const Vector3d inwards = (sphere.centre - point.position).normalized();
    const double angle = std::acos(inwards.dot(point.position.normalized()));
    EXPECT_TRUE(is_on_cap(sphere, point.position, angle + 1e-3));
    EXPECT_FALSE(is_on_cap(sphere, 2 * point.position, angle - 1e-3));
  }
}

}  // namespace slipstream::measure_test
