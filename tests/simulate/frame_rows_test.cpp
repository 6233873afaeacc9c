// Rows in vectors against their pixels one by one. Tier: every change.
#include "simulate/frame_rows.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "simulate/seen_scene.h"
#include "simulate/surface_packet.h"

namespace slipstream::frame_rows_test {

constexpr int width = 37;  // not whole vectors

TEST(FrameRows, NoiseIsThatOfEachPixel) {
  std::vector<double> row(width);
  set_gaussians(5, 3, 1000, row);
  for (int i = 0; i < width; ++i) EXPECT_NEAR(row[i], gaussian(5, 3, 1000 + i), 1e-12) << i;
}

TEST(FrameRows, BlurIsAGaussianToFourDeviations) {
  constexpr int reach = 12;
  std::vector<double> wide(width + 2 * reach), deviation(width), blurred(width);
  for (std::size_t i = 0; i < wide.size(); ++i) wide[i] = 100 * uniform(i);
  for (int i = 0; i < width; ++i) deviation[i] = i % 5 == 0 ? 0 : 0.1 * (i % 29);

  std::vector<const double*> before, after;
  for (int i = 1; i <= reach; ++i) {
    before.push_back(wide.data() + reach - i);
    after.push_back(wide.data() + reach + i);
  }
  blur_row(wide.data() + reach, before, after, deviation, blurred.data());

  for (int i = 0; i < width; ++i) {
    const double sigma = std::max(deviation[i], 1e-3);
    double sum = 0, weights = 0;
    for (int k = -reach; k <= reach; ++k) {
      if (std::abs(k) > std::ceil(4 * sigma)) continue;
      const double weight = std::exp(-0.5 * k * k / (sigma * sigma));
      sum += weight * wide[reach + i + k];
      weights += weight;
    }
    EXPECT_NEAR(blurred[i], sum / weights, 1e-11) << i;
  }
}

TEST(FrameRows, VeinsAreTheSameInPackets) {
  const Scene scene{{.shape = Board{100, 100}, .texture = veined_texture(0.2, 0.9, 20)}};
  const std::vector<PlacedBody> bodies = placed_at(scene, 0);
  LaneVectors directions;
  for (int i = 0; i < packet_rays; ++i) directions.set(i, {0.02 * i, 0.3 - 0.04 * i, 1});
  Lanes limit;
  limit.fill(1e9);

  const Eigen::Vector3d origin(-10, 5, -100);
  const PacketHits hits = first_hits(bodies, origin, directions, limit);
  const PacketSurfaces surfaces = surfaces_of(bodies, hits, origin, directions);
  for (int i = 0; i < packet_rays; ++i) {
    ASSERT_EQ(hits.body[i], 0);
    EXPECT_NEAR(surfaces.alpha[i], scene[0].texture(surfaces.point.at(i)), 1e-12) << i;
  }
}

}  // namespace slipstream::frame_rows_test
