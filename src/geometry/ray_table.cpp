#include "geometry/ray_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "base/parallel_rows.h"

namespace slipstream {
namespace {

constexpr int spacing = 8;
constexpr double largest_error = 1e-7;

/// Number of knots in one direction. The last is beyond the last pixel, so that every cell of a row
/// has 1 to `spacing` pixels.
int knot_count(int length) {
  return (length + spacing - 1) / spacing + 1;
}

/// The four knots around a pixel and their weights in the cubic through them.
struct CubicWeights {
  int first_knot;
  std::array<double, 4> weight;
};

CubicWeights cubic_weights(double pixel, int knots) {
  // Lagrange's weights of a cubic through knots 0 to 3, `t` of them past the first.
  const int first = std::clamp(static_cast<int>(pixel) / spacing - 1, 0, knots - 4);
  const double t = pixel / spacing - first;
  return {first,
          {-(t - 1) * (t - 2) * (t - 3) / 6, t * (t - 2) * (t - 3) / 2, -t * (t - 1) * (t - 3) / 2,
           t * (t - 1) * (t - 2) / 6}};
}

/// Exact rays at the knots.
struct Knots {
  Image<double> E_x, E_y;
};

Knots knots_of(const Lens& camera, int apart, Size size) {
  Knots knots{Image<double>(size), Image<double>(size)};
  for_each_pixel(size, [&](int column, int row) {
    const Eigen::Vector3d ray = ray_through(camera, {column * apart, row * apart});
    knots.E_x(column, row) = ray.x();
    knots.E_y(column, row) = ray.y();
  });
  return knots;
}

double interpolated(const Image<double>& knots, double x, double y) {
  const CubicWeights across = cubic_weights(x, knots.width());
  const CubicWeights down = cubic_weights(y, knots.height());

  double sum = 0;
  for_each_pixel_in_order({4, 4}, [&](int c, int r) {
    sum += down.weight[r] * across.weight[c] * knots(across.first_knot + c, down.first_knot + r);
  });

  return sum;
}

/// Whether the cubic is accurate at cell centres along borders and diagonals: the worst places.
bool meets_the_lens(const Lens& camera, const Knots& knots) {
  const auto meets = [&](double x, double y) {
    const Eigen::Vector3d exact = ray_through(camera, {x, y});
    return std::abs(interpolated(knots.E_x, x, y) - exact.x()) <= largest_error &&
           std::abs(interpolated(knots.E_y, x, y) - exact.y()) <= largest_error;
  };

  // From the first cell's centre to the last one's, in both directions.
  constexpr int samples = 12;
  const double right = camera.size.width - 1 - 0.5 * spacing;
  const double bottom = camera.size.height - 1 - 0.5 * spacing;

  for (int i = 0; i <= samples; ++i) {
    const double x = 0.5 * spacing + (right - 0.5 * spacing) * i / samples;
    const double y = 0.5 * spacing + (bottom - 0.5 * spacing) * i / samples;

    const bool all = meets(x, 0.5 * spacing) && meets(x, bottom) && meets(0.5 * spacing, y) &&
                     meets(right, y) && meets(x, y) && meets(x, 0.5 * spacing + bottom - y);
    if (!all) return false;
  }

  return true;
}

/// Weights of four knots at the pixels of a cell; all cells except the outermost share them.
using CellWeights = std::array<std::array<double, spacing>, 4>;

CellWeights cell_weights(int cell, int knots) {
  CellWeights weights{};
  for (int pixel = 0; pixel < spacing; ++pixel) {
    const CubicWeights cubic = cubic_weights(cell * spacing + pixel, knots);
    for (std::size_t k = 0; k < 4; ++k) weights[k][pixel] = cubic.weight[k];
  }
  return weights;
}

void fill_cell(const CellWeights& weights, const double* knots, float* pixels) {
  for (std::size_t i = 0; i < spacing; ++i) {
    pixels[i] = static_cast<float>(weights[0][i] * knots[0] + weights[1][i] * knots[1] +
                                   weights[2][i] * knots[2] + weights[3][i] * knots[3]);
  }
}

/// Fills rows of one table: cubic interpolation along the knots' columns, then along the row.
struct RowFiller {
  const Image<double>& knots;
  int width = 0;
  int cells = knots.width() - 1;
  CellWeights first = cell_weights(0, knots.width()), inner = cell_weights(1, knots.width()),
              last = cell_weights(cells - 1, knots.width());

  void operator()(int row, std::vector<double>& column, float* table) const {
    // 1. Down: the cubic in each column of knots gives knots of this row.
    const auto& [first_knot, weight] = cubic_weights(row, knots.height());
    const auto count = static_cast<std::size_t>(knots.width());
    column.resize(count);

    const std::array<const double*, 4> around{knots.row(first_knot), knots.row(first_knot + 1),
                                              knots.row(first_knot + 2), knots.row(first_knot + 3)};
    for (std::size_t c = 0; c < count; ++c) {
      column[c] = weight[0] * around[0][c] + weight[1] * around[1][c] + weight[2] * around[2][c] +
                  weight[3] * around[3][c];
    }

    // 2. Along the row: the outermost cells have knots on one side only; the last may have fewer
    //    than eight pixels.
    fill_cell(first, column.data(), table);
    for (int cell = 1; cell < cells - 1; ++cell) {
      fill_cell(inner, column.data() + cell - 1, table + cell * spacing);
    }

    std::array<float, spacing> end{};
    fill_cell(last, column.data() + cells - 3, end.data());
    const int start = (cells - 1) * spacing;
    std::copy_n(end.begin(), width - start, table + start);
  }
};

}  // namespace

std::optional<RayTable> ray_table(const Lens& camera) {
  if (!is_straight(camera) && !largest_tangent(camera)) return std::nullopt;

  // 1. Cubic interpolation between knots, if it is exact enough for this lens.
  const Size size = camera.size;
  if (knot_count(size.width) >= 4 && knot_count(size.height) >= 4) {
    const Knots knots =
        knots_of(camera, spacing, {knot_count(size.width), knot_count(size.height)});
    if (meets_the_lens(camera, knots)) {
      const RowFiller fill_x{knots.E_x, size.width}, fill_y{knots.E_y, size.width};
      RayTable table{Image<float>(size), Image<float>(size)};

      for_each_row(size.height, [&](int row) {
        std::vector<double> column;
        fill_x(row, column, table.E_x.row(row));
        fill_y(row, column, table.E_y.row(row));
      });
      return table;
    }
  }

  // 2. Otherwise every pixel's own ray.
  const Knots rays = knots_of(camera, 1, size);

  const auto finite = [](const Image<double>& E) {
    return std::ranges::all_of(E, [](double e) { return std::isfinite(e); });
  };

  if (!finite(rays.E_x) || !finite(rays.E_y)) return std::nullopt;
  return RayTable{converted<float>(rays.E_x), converted<float>(rays.E_y)};
}

}  // namespace slipstream
