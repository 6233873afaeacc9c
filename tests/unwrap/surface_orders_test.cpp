#include "slipstream/unwrap/surface_orders.h"

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace slipstream {
namespace {

using std::numbers::pi;

constexpr double periods = 16;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double wrapped(double y) {
  const double cycles = periods * y;
  return 2 * pi * (cycles - std::floor(cycles));
}

/// Two surfaces beside each other with a gap between them.
struct TwoSurfaces {
  Image<double> coordinate{{80, 40}, nan}, phase{{80, 40}, nan};

  TwoSurfaces() {
    for (int row = 0; row < 40; ++row) {
      for (int column = 0; column < 80; ++column) {
        if (column == 40) continue;
        const double y = (column < 40 ? 0.2 : 0.5) + 0.004 * column + 0.001 * row;
        coordinate(column, row) = y;
        phase(column, row) = wrapped(y);
      }
    }
  }
  [[nodiscard]] int order(int column, int row) const {
    return static_cast<int>(std::floor(periods * coordinate(column, row)));
  }
  [[nodiscard]] Image<double> found(const std::function<OrderRange(int, int)>& possible) const {
    Image<OrderRange> orders(phase.size());
    for (int row = 0; row < phase.height(); ++row) {
      for (int column = 0; column < phase.width(); ++column) {
        orders(column, row) = possible(column, row);
      }
    }
    return coordinate_by_surfaces(phase, periods, by_possible_orders(orders));
  }
};

TEST(SurfaceOrders, TakeWhatMostPixelsAllow) {
  const TwoSurfaces scene;
  // Of each pixel the next order is possible too, but for one in twelve.
  const Image<double> found = scene.found([&](int column, int row) {
    const int k = scene.order(column, row);
    return OrderRange{k, (column + 2 * row) % 12 == 0 ? k : k + 1};
  });
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 80; ++column) {
      if (column == 40) {
        EXPECT_TRUE(std::isnan(found(column, row)));
      } else {
        EXPECT_NEAR(found(column, row), scene.coordinate(column, row), 1e-12);
      }
    }
  }
}

TEST(SurfaceOrders, LeaveOutASurfaceThatCouldHaveTwo) {
  const TwoSurfaces scene;
  // On the right both orders are possible everywhere.
  const Image<double> found = scene.found([&](int column, int row) {
    const int k = scene.order(column, row);
    return OrderRange{k, column < 40 ? k : k + 1};
  });
  EXPECT_NEAR(found(10, 10), scene.coordinate(10, 10), 1e-12);
  EXPECT_TRUE(std::isnan(found(60, 10)));
}

TEST(SurfaceOrders, LeaveOutWhatIsSmallOrNowhere) {
  const TwoSurfaces scene;
  EXPECT_TRUE(std::isnan(scene.found([](int, int) { return OrderRange{}; })(10, 10)));
  const auto zero = [](const std::vector<SurfacePixel>&) { return std::optional(0); };
  EXPECT_TRUE(coordinate_by_surfaces({}, periods, zero).empty());
  EXPECT_TRUE(std::isnan(coordinate_by_surfaces(Image<double>({7, 9}, 1), periods, zero)(3, 3)));
  EXPECT_FALSE(std::isnan(coordinate_by_surfaces(Image<double>({8, 8}, 1), periods, zero)(3, 3)));
}

}  // namespace
}  // namespace slipstream
