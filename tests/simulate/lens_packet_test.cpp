// Rays of packets against those of the lens alone. Tier: every change.
#include "simulate/lens_packet.h"

#include <cmath>

#include <gtest/gtest.h>

#include "slipstream/named_scenes.h"

namespace slipstream {
namespace {

/// The largest difference from ray_through over a picture and half of its size beyond. Directions
/// that neither has are equal.
double largest_difference(const Lens& lens) {
  PacketRays rays(lens);
  double largest = 0;
  for (double row = -0.5 * lens.size.height; row < 1.5 * lens.size.height; row += 23.7) {
    for (double first = -0.5 * lens.size.width; first < 1.5 * lens.size.width; first += 33.3) {
      Lanes columns, rows;
      for (int i = 0; i < packet_rays; ++i) {
        columns[i] = first + 0.8 * i;
        rows[i] = row + 0.1 * i;
      }
      LaneVectors directions;
      rays.find(columns, rows, directions);
      for (int i = 0; i < packet_rays; ++i) {
        const Eigen::Vector3d alone = ray_through(lens, {columns[i], rows[i]});
        EXPECT_EQ(directions.at(i).allFinite(), alone.allFinite()) << columns[i] << ' ' << rows[i];
        if (alone.allFinite()) largest = std::max(largest, (directions.at(i) - alone).norm());
      }
    }
  }
  return largest;
}

TEST(PacketRays, AreThoseOfTheLens) {
  Lens lens = example_scanner({640, 480}).camera;
  EXPECT_LT(largest_difference(lens), 1e-14);

  // A lens that turns back within the picture, one with a tilted sensor, and none.
  lens.distortion.coefficients[0] = -1.5;
  EXPECT_LT(largest_difference(lens), 1e-13);
  lens.distortion = make_distortion(std::array{-0.1, 0.05, 1e-3, -1e-3, 0.01, 0.02, 0.01, 0.0, 1e-3,
                                               1e-3, -1e-3, 1e-3, 0.02, -0.03});
  EXPECT_LT(largest_difference(lens), 1e-14);
  lens.distortion = {};
  EXPECT_LT(largest_difference(lens), 1e-14);
}

}  // namespace
}  // namespace slipstream
