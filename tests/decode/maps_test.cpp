#include "slipstream/maps.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace slipstream::fringe_order_consensus_test {

constexpr double frequency = 16;
constexpr double fringe = 1 / frequency;

/// A surface across which y rises by a tenth of a fringe from pixel to pixel, lit everywhere and
/// without doubt.
struct Surface {
  Image<double> coordinate{{9, 7}};
  Image<double> doubt{{9, 7}};
  Image<std::uint8_t> lit{{9, 7}, 1};

  Surface() {
    for (int row = 0; row < 7; ++row) {
      for (int column = 0; column < 9; ++column) {
        coordinate(column, row) = 0.3 + 0.1 * fringe * column;
      }
    }
  }

  [[nodiscard]] Image<std::uint8_t> unconfirmed() const {
    return unconfirmed_fringe_orders(coordinate, doubt, lit, frequency);
  }
  [[nodiscard]] auto count_unconfirmed() const {
    const Image<std::uint8_t> image = unconfirmed();
    return std::count(image.begin(), image.end(), 1);
  }
};

TEST(Maps, FringeOrderConsensusBelievesASmoothSurface) {
  EXPECT_EQ(Surface().count_unconfirmed(), 0);
}

TEST(Maps, FringeOrderConsensusFindsAPixelThatIsOffByAnOrder) {
  Surface surface;
  surface.coordinate(4, 3) += fringe;
  EXPECT_EQ(surface.unconfirmed()(4, 3), 1);
  EXPECT_EQ(surface.count_unconfirmed(), 1);
}

TEST(Maps, FringeOrderConsensusIsWithinHalfAFringe) {
  Surface surface;
  surface.coordinate(4, 3) += 0.65 * fringe;  // its nearest neighbours lie 0.55 away
  EXPECT_EQ(surface.unconfirmed()(4, 3), 1);
}

TEST(Maps, FringeOrderConsensusWantsMoreNeighboursWhereTheFrequenciesDisagree) {
  Surface surface;
  surface.coordinate(4, 3) += fringe;
  surface.coordinate(5, 3) += fringe;
  EXPECT_EQ(surface.count_unconfirmed(), 0) << "each is confirmed by the other";
  surface.doubt(4, 3) = 0.3;
  EXPECT_EQ(surface.unconfirmed()(4, 3), 1);
  EXPECT_EQ(surface.unconfirmed()(5, 3), 0);
}

TEST(Maps, FringeOrderConsensusKeepsBothSidesOfADepthEdge) {
  Surface surface;
  for (int row = 0; row < 7; ++row) {
    for (int column = 5; column < 9; ++column) surface.coordinate(column, row) += 3.4 * fringe;
  }
  EXPECT_EQ(surface.count_unconfirmed(), 0);
}

TEST(Maps, FringeOrderConsensusListensToLitNeighboursOnly) {
  Surface surface;
  std::fill(surface.lit.begin(), surface.lit.end(), std::uint8_t{0});
  surface.lit(4, 3) = 1;
  EXPECT_EQ(surface.count_unconfirmed(), 1) << "nobody confirms a pixel that stands alone";
  surface.lit(4, 4) = 1;
  EXPECT_EQ(surface.count_unconfirmed(), 0) << "the one below and the one above confirm each other";
  surface.lit(4, 4) = 0;
  surface.lit(5, 4) = 1;
  surface.coordinate(5, 4) += 2 * fringe;
  EXPECT_EQ(surface.count_unconfirmed(), 2) << "one of two is wrong; neither is shown as right";
}

}  // namespace slipstream::fringe_order_consensus_test
