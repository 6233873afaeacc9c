
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "slipstream/image.h"
#include "slipstream/maps.h"
#include "slipstream/unwrapping.h"

namespace slipstream::temporal_unwrapping_test {

using std::numbers::pi;

double wrapped(double phase) {
  return phase - 2 * pi * std::floor(phase / (2 * pi));
}

TEST(BandUnwrapper, FringeOrderFindsThePeriodFromACoarseCoordinate) {
  for (const double f : {4.0, 16.0, 64.0}) {
    for (double y = 0; y < 1; y += 0.0037) {
      for (const double error : {-0.4 / f, 0.0, 0.4 / f}) {
        const double phi = wrapped(2 * pi * f * y);
        const int k = fringe_order(phi, f, y + error);
        EXPECT_NEAR(unwrapped_coordinate(phi, k, f), y, 1e-12);
      }
    }
  }
}

TEST(BandUnwrapper, FringeOrderResidualIsHowFarTheCoarseCoordinateLies) {
  constexpr double f = 16;
  constexpr double y = 0.43;
  const double phi = wrapped(2 * pi * f * y);
  for (const double error : {-0.45, -0.2, 0.0, 0.3, 0.45}) {
    const double coarse = y + error / f;
    const int k = fringe_order(phi, f, coarse);
    EXPECT_NEAR(fringe_order_residual(phi, f, coarse, k), error, 1e-12);
  }
}

TEST(BandUnwrapper, CoordinateInFieldKeepsNoiseAtTheEndWhereItArose) {
  constexpr int length = 1000;
  EXPECT_DOUBLE_EQ(coordinate_in_field(0.3, 1, length), 0.3);
  EXPECT_NEAR(coordinate_in_field(0.9996, 1, length), -0.0004, 1e-15);  // left of pixel 0
  EXPECT_NEAR(coordinate_in_field(1.0002, 1, length), 0.0002, 1e-15);   // pixel 0
  EXPECT_DOUBLE_EQ(coordinate_in_field(0.999, 1, length), 0.999);       // the last pixel
  EXPECT_NEAR(coordinate_in_field(-0.001, 1, length), 0.999, 1e-15);
  // At half a period the field is followed by as much that is not lit; the cut is in its middle.
  EXPECT_NEAR(coordinate_in_field(1.9, 2, length), -0.1, 1e-15);
  EXPECT_DOUBLE_EQ(coordinate_in_field(1.1, 2, length), 1.1);
}

TEST(BandUnwrapper, ModulationMaskKeepsTheLeastModulationAndLeavesOutNan) {
  Image<double> modulation({3, 1});
  modulation(0, 0) = 14.999;
  modulation(1, 0) = 15;
  modulation(2, 0) = std::nan("");
  const Image<std::uint8_t> mask = modulation_mask(modulation, 15);
  EXPECT_EQ(mask(0, 0), 0);
  EXPECT_EQ(mask(1, 0), 1);
  EXPECT_EQ(mask(2, 0), 0);
}

}  // namespace slipstream::temporal_unwrapping_test
