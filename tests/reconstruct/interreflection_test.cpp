// What light from surface to surface does to phases, and that a carrier keeps it out of them.
#include <cmath>
#include <cstdio>
#include <numbers>

#include <gtest/gtest.h>

#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "tests/reconstruct/agreement.h"

namespace slipstream::interreflection_test {

/// Two bright walls that meet at a right angle, open to the camera, their edge upright.
Scene corner(const Scanner& scanner) {
  const WorkingVolume volume = working_volume(scanner);
  const double side = 1.2 * volume.extent;
  Scene walls;
  for (const int turn : {1, -1}) {
    Body& wall =
        walls.emplace_back(Body{.shape = Board{side, 2 * side}, .shading = Shading::lambertian});
    wall.pose.translate(volume.centre + Eigen::Vector3d(0, 0, 0.3 * volume.extent));
    wall.pose.rotate(Eigen::AngleAxisd(turn * std::numbers::pi / 4, Eigen::Vector3d::UnitY()));
    wall.pose.translate(Eigen::Vector3d(turn * side / 2, 0, 0));
  }
  return walls;
}

struct Errors {
  int points = 0;
  double wrong = 0;  ///< share of points at a wrong fringe order
  double bias = 0;   ///< of the others: RMS over the picture's columns of their mean error, mm
};

/// A column sees walls and light that are alike along it; noise is not.
Errors errors_of(const VirtualScan& scan, const Scanner& scanner, const Strategy& strategy,
                 const Photometry& photometry) {
  const FrameSet frames = take_again(scan, pattern_set(strategy, Axis::x), photometry);
  Engine engine(setup_of(scanner, strategy, Axis::x));
  Cloud cloud;
  Maps maps;
  engine.cloud_and_maps(frames, cloud, maps);
  Errors errors;
  double squares = 0;
  for (int column = 0; column < cloud.z.width(); ++column) {
    double sum = 0, right = 0;
    for (int row = 0; row < cloud.z.height(); ++row) {
      if (cloud.validity(column, row) != Validity::valid) continue;
      ++errors.points;
      const double off = maps.coordinate(column, row) - scan.coordinate(column, row);
      if (std::abs(off) > 0.5 / highest_frequency(strategy)) {
        ++errors.wrong;
        continue;
      }
      sum += cloud.z(column, row) - scan.depth(column, row);
      ++right;
    }
    if (right > 0) squares += sum * sum / (right * right);
  }
  errors.wrong /= errors.points;
  errors.bias = std::sqrt(squares / cloud.z.width());
  std::printf("%s: %d points, %.2f %% at a wrong fringe order, the others %.3f mm off\n",
              label_of(strategy).c_str(), errors.points, 100 * errors.wrong, errors.bias);
  return errors;
}

/// As many frames of as many periods, in a corner that lights itself.
TEST(Interreflection, IsKeptOutOfThePhaseByACarrier) {
  const Scanner scanner = example_scanner({160, 120});
  const Photometry photometry{
      .ambient = 5,
      .noise_variance = 0.1,
      .physics = {.projector_pixels = true, .projector = {.blur = 0.8}, .bounces = 128}};
  const VirtualScan scan =
      take_scan(scanner, corner(scanner), pattern_set(PhaseMeasuring{}, Axis::x), photometry);
  const Errors plain =
      errors_of(scan, scanner, MultiFrequency{.steps = {6}, .periods = {1, 16}}, photometry);
  const Errors modulated = errors_of(scan, scanner, ModulatedPhaseShifting{}, photometry);
  EXPECT_GT(plain.wrong, 0.05) << "else this shows nothing";
  EXPECT_EQ(modulated.wrong, 0);
  EXPECT_GT(modulated.points, 17000);
  EXPECT_LT(modulated.bias, plain.bias / 5);
}

}  // namespace slipstream::interreflection_test
