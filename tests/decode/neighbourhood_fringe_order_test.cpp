#include "slipstream/decode/neighbourhood_fringe_order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace slipstream::neighbourhood_fringe_order_test {

constexpr Size size{24, 20};

/// A surface of `coordinate` periods; each pixel's cue says so with the same certainty, but for
/// those that are told otherwise.
struct Surface {
  Image<double> periods{size};
  Image<int> said{size};
  Image<std::uint8_t> lit{size, 1};
  double certainty = 3;

  template <class Coordinate>
  explicit Surface(const Coordinate& coordinate) {
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        periods(column, row) = coordinate(column, row);
        said(column, row) = truth(column, row);
      }
    }
  }

  [[nodiscard]] int truth(int column, int row) const {
    return static_cast<int>(std::floor(periods(column, row)));
  }

  [[nodiscard]] int count_wrong() const {
    Image<double> phase(size);
    std::transform(periods.begin(), periods.end(), phase.begin(),
                   [](double p) { return 2 * std::numbers::pi * (p - std::floor(p)); });
    Image<int> orders = said;
    choose_with_neighbours(orders, phase, lit, [&](int column, int row, int order) {
      const double off = order - said(column, row);
      return certainty * off * off;
    });
    int wrong = 0;
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        if (orders(column, row) != truth(column, row)) ++wrong;
      }
    }
    return wrong;
  }
};

double slope(int column, int row) {
  return 3.2 + 0.07 * column + 0.03 * row;
}

TEST(NeighbourhoodFringeOrder, MendsScatteredPixelsAlsoWhereThePhaseWraps) {
  Surface surface(slope);
  EXPECT_EQ(surface.count_wrong(), 0);
  for (int row = 1; row < size.height; row += 3) {
    for (int column = row % 2; column < size.width; column += 3) {
      surface.said(column, row) += column % 2 == 0 ? 1 : -1;
    }
  }
  EXPECT_EQ(surface.count_wrong(), 0);
}

TEST(NeighbourhoodFringeOrder, DoesNotReachAcrossAnEdge) {
  // A tongue one pixel wide before a wall whose cue says another order, everywhere.
  Surface surface(
      [](int column, int row) { return slope(column, row) + (column == 12 && row > 5 ? 2.4 : 0); });
  EXPECT_EQ(surface.count_wrong(), 0);
}

TEST(NeighbourhoodFringeOrder, KeepsWhatStandsAtAnEdgeOfWholePeriods) {
  // The wrapped phase shows nothing of it; the corner has most of its neighbours on the other side.
  Surface surface(
      [](int column, int row) { return slope(column, row) + (column > 8 && row > 8 ? 1 : 0); });
  EXPECT_EQ(surface.count_wrong(), 0);
}

TEST(NeighbourhoodFringeOrder, AsksNobodyInTheDark) {
  Surface surface(slope);
  surface.said(10, 10) += 1;
  for (const auto& [column, row] : {std::pair{9, 10}, {11, 10}, {10, 9}, {10, 11}}) {
    surface.lit(column, row) = 0;
  }
  EXPECT_EQ(surface.count_wrong(), 1) << "nothing is known of it but what it says itself";
}

TEST(NeighbourhoodFringeOrder, EvidenceOfItsOwnStandsAgainstTheNeighbours) {
  Surface surface(slope);
  surface.said(10, 10) += 1;
  surface.certainty = 1000;
  EXPECT_EQ(surface.count_wrong(), 1);
}

}  // namespace slipstream::neighbourhood_fringe_order_test
