#include "slipstream/decode/maps.h"

#include <algorithm>
#include <cmath>

#include "slipstream/base/parallel_rows.h"

namespace slipstream {
namespace {

int agreeing_neighbours(const Image<double>& coordinate, const Image<std::uint8_t>& lit, int column,
                        int row, double half_fringe) {
  int agreeing = 0;
  const double y = coordinate(column, row);
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, lit.height() - 1); ++r) {
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, lit.width() - 1); ++c) {
      if (lit(c, r) == 0 || (c == column && r == row)) continue;
      if (std::abs(coordinate(c, r) - y) < half_fringe) ++agreeing;
    }
  }
  return agreeing;
}

}  // namespace

Image<std::uint8_t> modulation_mask(const Image<double>& modulation, double minimum) {
  Image<std::uint8_t> mask(modulation.size());
  std::transform(modulation.begin(), modulation.end(), mask.begin(),
                 [minimum](double B) -> std::uint8_t { return B >= minimum ? 1 : 0; });
  return mask;
}

Image<std::uint8_t> unconfirmed_fringe_orders(const Image<double>& coordinate,
                                              const Image<double>& doubt,
                                              const Image<std::uint8_t>& lit, double frequency,
                                              const FringeOrderConsensus& settings) {
  Image<std::uint8_t> unconfirmed(coordinate.size());
  for_each_row(coordinate.height(), [&](int row) {
    for (int column = 0; column < coordinate.width(); ++column) {
      if (lit(column, row) == 0) continue;
      const int wanted = doubt(column, row) > settings.largest_doubt ? settings.fewest_if_doubtful
                                                                     : settings.fewest_neighbours;
      const int agreeing = agreeing_neighbours(coordinate, lit, column, row, 0.5 / frequency);
      unconfirmed(column, row) = agreeing >= wanted ? 0 : 1;
    }
  });
  return unconfirmed;
}

}  // namespace slipstream
