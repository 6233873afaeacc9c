#include "check/geometry_evidence.h"

#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "slipstream/named_scenes.h"

namespace slipstream::geometry_evidence_test {

/// The example scanner, with a projector without distortion, which the evidence ignores.
Scanner rig() {
  Scanner scanner = example_scanner({640, 480});
  scanner.projector.distortion = {};
  return scanner;
}

constexpr double depth = 600;

/// The projector coordinate that a camera pixel sees on a plane at this depth.
double coordinate_at(const Scanner& scanner, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d point = depth * ray_through(scanner.camera, pixel);
  return project(scanner.projector, in_projector_frame(scanner, point)).x() /
         scanner.projector.size.width;
}

/// Samples of the plane, in pictures that were flipped so. Their changes are right by the phase or
/// by the coordinate alone.
std::vector<CoordinateSample> samples_of(const Scanner& scanner, bool flipped, bool by_phase) {
  std::vector<CoordinateSample> samples;
  for (int row = 160; row < 320; row += 20) {
    for (int column = 240; column < 400; column += 20) {
      const Eigen::Vector2d pixel(column, row);
      const double here = coordinate_at(scanner, pixel);
      const Eigen::Vector2d below(column, flipped ? row - 1 : row + 1);
      const Eigen::Vector2d change(coordinate_at(scanner, {column + 1, row}) - here,
                                   coordinate_at(scanner, below) - here);
      const Eigen::Vector2d none(0, 0);
      samples.push_back(
          {.pixel = {column, flipped ? 479 - row : row},
           .coordinate = here,
           .change = CoordinateSample::Change{by_phase ? none : change, by_phase ? change : none}});
    }
  }
  return samples;
}

TEST(GeometryEvidence, OfAPlaneIsItsDepthAndASlopeOfOne) {
  const Scanner scanner = rig();
  for (const bool flipped : {false, true}) {
    const auto found = geometry_evidence(samples_of(scanner, flipped, true), {.periods = 16},
                                         scanner, Axis::x, {.rows = flipped});
    EXPECT_NEAR(found.median_depth, depth, 1e-6) << flipped;
    EXPECT_NEAR(found.slope, 1, 1e-3) << flipped;
    EXPECT_EQ(found.outside + found.without_point, 0) << flipped;
  }
}

// The phase of 400 periods changes by a good part of a period from pixel to pixel.
TEST(GeometryEvidence, TakesTheCoordinateWhereThePhaseWouldWrap) {
  const Scanner scanner = rig();
  const auto found =
      geometry_evidence(samples_of(scanner, false, false), {.periods = 400}, scanner, Axis::x);
  EXPECT_NEAR(found.slope, 1, 1e-3);
}

}  // namespace slipstream::geometry_evidence_test
