// Pictures of symbols that are known by their neighbours, and pictures of anything.

#include "decode/neighbours.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

#include <gtest/gtest.h>

#include "decode/located_pixels.h"

namespace slipstream::neighbours_test {

class Neighbours : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] SymbolGrid grid() const {
    return GetParam() ? symbol_array(30, 20) : coloured_stripes(64);
  }
  [[nodiscard]] int shown() const { return GetParam() ? 1 : 3; }
};

/// The place in the field of a pixel on a surface that leans and bends.
double coordinate_at(double along, double across) {
  return 0.1 + 0.8 * along + 0.03 * std::sin(6 * along) + 0.05 * across;
}

TEST_P(Neighbours, SayWherePixelsAre) {
  const SymbolGrid shown_grid = grid();
  for (const Axis axis : {Axis::x, Axis::y}) {
    const Size size = axis == Axis::x ? Size{480, 320} : Size{320, 480};
    const int length = length_along(axis, size), breadth = length_along(across(axis), size);
    const auto place = [&](int column, int row) {
      return std::pair{(axis == Axis::x ? column : row) / static_cast<double>(length),
                       (axis == Axis::x ? row : column) / static_cast<double>(breadth)};
    };
    std::vector<Image<float>> frames(static_cast<std::size_t>(shown()), Image<float>(size));
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        const auto [along, beside] = place(column, row);
        for (std::size_t n = 0; n < frames.size(); ++n) {
          // Paint and light of the room.
          const double shade = 0.7 + 0.2 * std::sin(0.03 * column + 0.02 * row);
          frames[n](column, row) = static_cast<float>(
              shade * (5 + 180 * grid_intensity(shown_grid, static_cast<int>(n),
                                                coordinate_at(along, beside), beside)));
        }
      }
    }
    const LocatedPixels located = located_by_neighbours(shown_grid, axis, frames);
    std::size_t points = 0;
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        const float y = located.coordinate(column, row);
        if (std::isnan(y)) continue;
        ++points;
        const auto [along, beside] = place(column, row);
        ASSERT_NEAR(y, coordinate_at(along, beside), 0.25 / shown_grid.columns)
            << column << " " << row;
        ASSERT_NEAR(located.modulation(column, row), 63, 35);
      }
    }
    EXPECT_GT(points, located.coordinate.pixel_count() * 3 / 4) << name_of(axis);
  }
}

TEST_P(Neighbours, SayNothingOfAnythingElse) {
  std::minstd_rand random;
  for (const Size size : {Size{1, 1}, {2, 3}, {5, 4}, {40, 1}, {1, 40}, {64, 64}, {320, 240}}) {
    for (const int kind : {0, 1, 2, 3}) {
      std::vector<Image<float>> frames(static_cast<std::size_t>(shown()), Image<float>(size));
      for (Image<float>& frame : frames) {
        for (int row = 0; row < size.height; ++row) {
          for (int column = 0; column < size.width; ++column) {
            const auto noise = static_cast<float>(random() % 256);
            const float checks = (column / 6 + row / 6) % 2 == 0 ? 200 : 20;
            const float levels[] = {noise, 100, checks, NAN};
            frame(column, row) = levels[kind];
          }
        }
      }
      for (const Axis axis : {Axis::x, Axis::y}) {
        const LocatedPixels located = located_by_neighbours(grid(), axis, frames);
        std::size_t points = 0;
        for (const float y : located.coordinate) points += std::isnan(y) ? 0U : 1U;
        EXPECT_LE(points, located.coordinate.pixel_count() / 200)
            << size.width << "x" << size.height << " " << kind;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Grids, Neighbours, testing::Bool());

}  // namespace slipstream::neighbours_test
