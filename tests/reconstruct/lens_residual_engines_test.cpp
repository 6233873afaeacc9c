// Engines with residual maps of both lenses agree with the equations, without an iteration per
// pixel.
#include <algorithm>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/lens_residual.h"
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

}  // namespace slipstream::lens_residual_engines_test
