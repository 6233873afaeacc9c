#include "decode/surface_orders.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>

namespace slipstream::surface_orders_test {

using std::numbers::pi;

constexpr double periods = 16;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double wrapped(double y) {
  const double cycles = periods * y;
  return 2 * pi * (cycles - std::floor(cycles));
}

OrderRange range(int first, int last) {
  return {static_cast<std::int16_t>(first), static_cast<std::int16_t>(last)};
}

/// Two surfaces beside each other with a gap between them.
struct TwoSurfaces {
  Image<double> coordinate{{80, 40}, nan};
  Image<float> phase{{80, 40}, static_cast<float>(nan)};

  TwoSurfaces() {
    for (int row = 0; row < 40; ++row) {
      for (int column = 0; column < 80; ++column) {
        if (column == 40) continue;
        const double y = (column < 40 ? 0.2 : 0.5) + 0.004 * column + 0.001 * row;
        coordinate(column, row) = y;
        phase(column, row) = static_cast<float>(wrapped(y));
      }
    }
  }
  [[nodiscard]] int order(int column, int row) const {
    return static_cast<int>(std::floor(periods * coordinate(column, row)));
  }
  [[nodiscard]] Image<int> found(const std::function<OrderRange(int, int)>& possible) const {
    Image<OrderRange> orders(phase.size());
    for (int row = 0; row < phase.height(); ++row) {
      for (int column = 0; column < phase.width(); ++column) {
        orders(column, row) = possible(column, row);
      }
    }
    return SurfaceOrders()(phase, by_possible_orders(orders));
  }
};

TEST(SurfaceOrders, TakeWhatMostPixelsAllow) {
  const TwoSurfaces scene;
  // Of each pixel the next order is possible too, but for one in twelve.
  const Image<int> found = scene.found([&](int column, int row) {
    const int k = scene.order(column, row);
    return range(k, (column + 2 * row) % 12 == 0 ? k : k + 1);
  });
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 80; ++column) {
      if (column == 40) {
        EXPECT_EQ(found(column, row), SurfaceOrders::none);
      } else {
        EXPECT_EQ(found(column, row), scene.order(column, row));
      }
    }
  }
}

TEST(SurfaceOrders, LeaveOutASurfaceThatCouldHaveTwo) {
  const TwoSurfaces scene;
  // On the right both orders are possible everywhere.
  const Image<int> found = scene.found([&](int column, int row) {
    const int k = scene.order(column, row);
    return range(k, column < 40 ? k : k + 1);
  });
  EXPECT_EQ(found(10, 10), scene.order(10, 10));
  EXPECT_EQ(found(60, 10), SurfaceOrders::none);
}

TEST(SurfaceOrders, LeaveOutASurfaceThatOneInTwentyPixelsExcludes) {
  const TwoSurfaces scene;
  const Image<int> found = scene.found([&](int column, int row) {
    const int k = scene.order(column, row);
    return (column + 2 * row) % 20 == 0 ? OrderRange{} : range(k, k);
  });
  EXPECT_EQ(found(10, 10), SurfaceOrders::none);
}

/// The orders that a coordinate gets if each pixel allows its own alone, whether all are right.
bool are_right(const Image<double>& y, double second_ratio = 0) {
  Image<float> phase(y.size());
  SecondPhase second{.wrapped = phase, .ratio = static_cast<float>(second_ratio)};
  Image<OrderRange> own(y.size());
  for (std::size_t i = 0; i < y.pixel_count(); ++i) {
    phase.begin()[i] = static_cast<float>(wrapped(y.begin()[i]));
    second.wrapped.begin()[i] = static_cast<float>(wrapped(second_ratio * y.begin()[i]));
    const int k = static_cast<int>(std::floor(periods * y.begin()[i]));
    own.begin()[i] = range(k, k);
  }
  const Image<int> found =
      SurfaceOrders()(phase, by_possible_orders(own), second_ratio > 0 ? &second : nullptr);
  return std::ranges::equal(found, own, {}, {}, &OrderRange::first);
}

TEST(SurfaceOrders, PartSurfacesAThirdOfAPeriodApart) {
  Image<double> y({80, 40});
  for (const double apart : {3.3, 3.0}) {
    for (int row = 0; row < 40; ++row) {
      for (int column = 0; column < 80; ++column) {
        y(column, row) = 0.2 + 0.003 * column + (column < 40 ? 0 : apart / periods);
      }
    }
    // Of whole periods only a second phase tells.
    EXPECT_EQ(are_right(y), apart == 3.3);
    EXPECT_TRUE(are_right(y, 1.25));
  }
}

TEST(SurfaceOrders, LeaveOutWhatIsSmallOrNowhere) {
  const TwoSurfaces scene;
  EXPECT_EQ(scene.found([](int, int) { return OrderRange{}; })(10, 10), SurfaceOrders::none);
  const auto zero = [](const ConnectedSurface&) { return std::optional(0); };
  EXPECT_TRUE(SurfaceOrders()({}, zero).empty());
  EXPECT_EQ(SurfaceOrders()(Image<float>({7, 9}, 1), zero)(3, 3), SurfaceOrders::none);
  EXPECT_EQ(SurfaceOrders()(Image<float>({8, 8}, 1), zero)(3, 3), 0);
}

}  // namespace slipstream::surface_orders_test
