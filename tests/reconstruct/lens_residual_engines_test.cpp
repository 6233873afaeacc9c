// Engines with residual maps of both lenses agree with the equations, without an iteration per
// pixel.
#include <algorithm>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/lens_residual.h"
#include "reconstruct/epipolar_tables.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/virtual_world.h"
#include "tests/reconstruct/agreement.h"

namespace slipstream::lens_residual_engines_test {

LensResidual random_residual(Size picture, int degree, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> number(0, 0.1);
  LensResidual residual{.centre = {picture.width / 2.0, picture.height / 2.0},
                        .half = {picture.width / 2.0, picture.height / 2.0}};
  for (int i = 0; i < residual_term_count(degree); ++i) {
    const double x = number(random), y = number(random);
    residual.terms.emplace_back(x, y);
  }
  return residual;
}

Scanner mapped_scanner(int camera_degree, int projector_degree) {
  Scanner scanner = example_scanner({160, 120});
  scanner.camera.residual = random_residual(scanner.camera.size, camera_degree, 1);
  scanner.projector.residual = random_residual(scanner.projector.size, projector_degree, 2);
  return scanner;
}

TEST(LensResidualEngines, AgreeWithTheEquations) {
  const Sequence sequence{.strategy = DualFrequency{.steps = 4, .high = 16, .low = 1}};
  for (const auto& [camera, projector] : {std::pair(3, 2), std::pair(8, 4), std::pair(14, 4)}) {
    const Scanner scanner = mapped_scanner(camera, projector);
    const FrameSet frames =
        take_scan(scanner, scene_named("sphere", scanner), pattern_set(sequence), {.ambient = 5})
            .frames;

    const EngineSetup setup{scanner, sequence, {}};
    const ReferenceResult exact = by_equations(setup, frames);
    std::string why_not;
    const auto fused = FusedEngine::make(setup, {}, &why_not);
    ASSERT_TRUE(fused) << why_not;

    Cloud cloud;
    FusedMemory memory;
    (*fused)(frames, {.cloud = &cloud}, memory);
    const Agreement agreement = compare(scanner, Axis::x, cloud, exact);
    EXPECT_GT(agreement.points, 3000U);
    EXPECT_LE(agreement.worst, depth_bound) << camera << ", " << projector;
    EXPECT_LE(agreement.other_validity, 2U);
  }
}

TEST(LensResidualEngines, MeasureWhatTheMapsDescribe) {
  const Scanner scanner = mapped_scanner(8, 4);
  Scanner without = scanner;
  without.camera.residual = without.projector.residual = {};

  const Sequence sequence{.strategy = DualFrequency{.steps = 4, .high = 16, .low = 1}};
  const VirtualScan scan = take_scan(scanner, scene_named("board", scanner), pattern_set(sequence),
                                     {.bits = std::nullopt});
  const auto worst = [&](const Scanner& by) {
    Cloud cloud;
    Engine(by, sequence).cloud(scan.frames, cloud);
    double largest = 0;
    for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
      if (cloud.validity(column, row) != Validity::valid) return;
      largest = std::max(largest, std::abs(cloud.z(column, row) - scan.depth(column, row)));
    });
    return largest;
  };

  EXPECT_LT(worst(scanner), 0.01);
  EXPECT_GT(worst(without), 0.2);
}

TEST(LensResidualEngines, SayThatAProjectorBendsTooMuchForItsMap) {
  Scanner bent = mapped_scanner(2, 2);
  bent.projector.distortion = make_distortion(std::vector{-9.0, 0.0, 0.0, 0.0});
  const Sequence sequence{.strategy = DualFrequency{.steps = 4, .high = 16, .low = 1}};

  std::string why_not;
  EXPECT_FALSE(FusedEngine::make({bent, sequence, {}}, {}, &why_not));
  EXPECT_EQ(why_not, "the projector's lens bends too much for its residual map");
}

// Tables hold the second camera's map by pixel; its exact shift needs an iteration.
TEST(LensResidualEngines, PlacePointsInASecondCamera) {
  constexpr double depth = 500;
  const Scanner first = mapped_scanner(4, 2);
  Scanner second = second_scanner(first);
  second.camera.residual = random_residual(second.camera.size, 4, 3);
  const Size picture = second.camera.size;

  const EpipolarTables tables(first, second, Axis::x);
  int seen = 0;
  double worst = 0;
  for_each_pixel_in_order(tables.size(), [&](int column, int row) {
    const Eigen::Vector3d point = depth * ray_through(first.camera, {column, row});
    const Eigen::Vector3d from_second =
        second.rotation.transpose() * (in_projector_frame(first, point) - second.translation);
    const Eigen::Vector2d exact = project(second.camera, from_second);
    const bool is_inside =
        exact.minCoeff() >= 1 && exact.x() <= picture.width - 2 && exact.y() <= picture.height - 2;
    if (!is_inside) return;  // beyond its rim the table has the rim's shift

    const auto w = static_cast<float>(1 / depth);
    const Eigen::Vector2d placed = tables.place(column, row, w).cast<double>();
    worst = std::max(worst, (placed - exact).norm());
    ++seen;
  });
  EXPECT_GT(seen, 1000);
  EXPECT_LT(worst, 0.01);
}

}  // namespace slipstream::lens_residual_engines_test
