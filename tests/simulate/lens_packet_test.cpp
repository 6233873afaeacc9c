// Rays of packets against those of the lens alone. Tier: every change.
#include "simulate/lens_packet.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "slipstream/named_scenes.h"

namespace slipstream::lens_packet_test {

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

/// A map of a few tenths of a pixel across the picture of a lens.
LensResidual wavy_residual(const Lens& lens) {
  constexpr int terms_of_degree_3 = 10;
  const Eigen::Vector2d half(lens.size.width / 2.0, lens.size.height / 2.0);

  LensResidual residual{.centre = half, .half = half};
  for (int i = 0; i < terms_of_degree_3; ++i) {
    residual.terms.emplace_back(0.2 * std::cos(i), 0.2 * std::sin(2 * i));
  }
  return residual;
}

/// The largest difference, pixels, from project for points in the middle of the scanner's volume.
/// Those face the light and lie in the projector's picture.
double largest_lit_difference(const Scanner& scanner) {
  const Eigen::Vector3d light = projector_centre(scanner);
  const WorkingVolume volume = working_volume(scanner);

  PacketSurfaces surfaces{};
  for (int i = 0; i < packet_rays; ++i) {
    const Eigen::Vector3d towards(std::cos(i), std::sin(i), std::cos(3 * i));
    const Eigen::Vector3d point = volume.centre + 0.15 * volume.extent * towards;
    surfaces.point.set(i, point);
    surfaces.normal.set(i, (light - point).normalized());
  }

  const LightingPixels pixels = lighting_pixels(scanner, light, surfaces);
  double largest = 0;
  for (int i = 0; i < packet_rays; ++i) {
    EXPECT_EQ(pixels.lit[i], 1) << i;
    const Eigen::Vector2d alone =
        project(scanner.projector, in_projector_frame(scanner, surfaces.point.at(i)));
    const Eigen::Vector2d off = Eigen::Vector2d(pixels.column[i], pixels.row[i]) - alone;
    largest = std::max(largest, off.norm());
  }
  return largest;
}

TEST(LensPacket, RaysAreThoseOfTheLens) {
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

TEST(LensPacket, RaysAreThoseOfALensWithAResidualMap) {
  Lens lens = example_scanner({640, 480}).camera;
  lens.residual = wavy_residual(lens);
  EXPECT_LT(largest_difference(lens), 1e-12);

  lens.distortion = {};
  EXPECT_LT(largest_difference(lens), 1e-12);
}

TEST(LensPacket, LightingPixelsAreThoseOfTheProjector) {
  Scanner scanner = example_scanner({640, 480});
  EXPECT_LT(largest_lit_difference(scanner), 1e-9);

  // With a residual map, with and without distortion.
  scanner.projector.residual = wavy_residual(scanner.projector);
  EXPECT_LT(largest_lit_difference(scanner), 1e-9);
  scanner.projector.distortion = {};
  EXPECT_LT(largest_lit_difference(scanner), 1e-9);
}

}  // namespace slipstream::lens_packet_test
