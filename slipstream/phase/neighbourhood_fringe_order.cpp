#include "slipstream/phase/neighbourhood_fringe_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "slipstream/image/parallel_rows.h"

namespace slipstream {
namespace {

/// The steps of the wrapped phase from each pixel to the one beside and the one below, in periods,
/// nearest to zero, and whether the surface goes on across them.
class Links {
 public:
  Links(const Image<double>& phase, const Image<std::uint8_t>& lit,
        const NeighbourhoodChoice& settings)
      : phase_(phase), lit_(lit), settings_(settings), go_on_(phase.size()) {
    for_each_row(phase.height(), [&](int row) {
      for (int column = 0; column < phase.width(); ++column) {
        const bool right = goes_on(column, row, 1, 0);
        const bool down = goes_on(column, row, 0, 1);
        go_on_(column, row) = static_cast<std::uint8_t>((right ? 1 : 0) + (down ? 2 : 0));
      }
    });
  }

  /// From (column, row) one pixel along (dx, dy), dx + dy = +-1.
  [[nodiscard]] bool linked(int column, int row, int dx, int dy) const {
    const int c = std::min(column, column + dx);
    const int r = std::min(row, row + dy);
    const bool inside = c >= 0 && r >= 0 && std::max(column, column + dx) < go_on_.width() &&
                        std::max(row, row + dy) < go_on_.height();
    return inside && (go_on_(c, r) & (dx != 0 ? 1 : 2)) != 0;
  }

  /// Order at the next pixel less order here, where they are linked.
  [[nodiscard]] int order_step(int column, int row, int dx, int dy) const {
    const double difference = phase_(column, row) - phase_(column + dx, row + dy);
    return static_cast<int>(std::lround(difference / (2 * std::numbers::pi)));
  }

 private:
  [[nodiscard]] bool has(int column, int row) const {
    return column >= 0 && row >= 0 && column < phase_.width() && row < phase_.height() &&
           lit_(column, row) != 0;
  }
  [[nodiscard]] double step(int column, int row, int dx, int dy) const {
    const double periods =
        (phase_(column + dx, row + dy) - phase_(column, row)) / (2 * std::numbers::pi);
    return periods - std::round(periods);
  }

  /// Not an edge: an edge differs from the steps on either side of it.
  [[nodiscard]] bool goes_on(int column, int row, int dx, int dy) const {
    if (!has(column, row) || !has(column + dx, row + dy)) return false;
    const double here = step(column, row, dx, dy);
    if (std::abs(here) > settings_.steepest) return false;
    const bool has_before = has(column - dx, row - dy);
    const bool has_after = has(column + 2 * dx, row + 2 * dy);
    if (!has_before && !has_after) return true;
    const auto alike = [&](double other) { return std::abs(here - other) <= settings_.roughest; };
    return (has_before && alike(step(column - dx, row - dy, dx, dy))) ||
           (has_after && alike(step(column + dx, row + dy, dx, dy)));
  }

  const Image<double>& phase_;
  const Image<std::uint8_t>& lit_;
  const NeighbourhoodChoice& settings_;
  Image<std::uint8_t> go_on_;
};

constexpr std::array<std::array<int, 2>, 4> directions{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

/// A pixel on the same surface, and its order less that of the pixel in the middle.
struct Neighbour {
  int column, row, order_step;
};

/// All that are reached from the middle within the window; the middle comes first.
std::vector<Neighbour> same_surface(const Links& links, int column, int row, int radius) {
  std::array<bool, 25> reached{};
  const auto place = [&](int c, int r) {
    const int index = (r - row + 2) * 5 + c - column + 2;
    return static_cast<std::size_t>(index);
  };
  std::vector<Neighbour> found{{column, row, 0}};
  found.reserve(25);
  reached[place(column, row)] = true;
  for (std::size_t next = 0; next < found.size(); ++next) {
    const auto [c, r, order_step] = found[next];
    for (const auto& [dx, dy] : directions) {
      if (std::abs(c + dx - column) > radius || std::abs(r + dy - row) > radius) continue;
      if (reached[place(c + dx, r + dy)] || !links.linked(c, r, dx, dy)) continue;
      reached[place(c + dx, r + dy)] = true;
      found.push_back({c + dx, r + dy, order_step + links.order_step(c, r, dx, dy)});
    }
  }
  return found;
}

bool neighbours_disagree(const Links& links, const Image<int>& orders, int column, int row) {
  return std::any_of(directions.begin(), directions.end(), [&](const auto& direction) {
    const auto [dx, dy] = direction;
    return links.linked(column, row, dx, dy) &&
           orders(column + dx, row + dy) !=
               orders(column, row) + links.order_step(column, row, dx, dy);
  });
}

/// The order at the middle that costs least, among its own and those that neighbours imply.
int least_cost_order(const std::vector<Neighbour>& surface, const Image<int>& orders,
                     const Image<int>& own, const FringeOrderCost& cost,
                     const NeighbourhoodChoice& settings) {
  const auto total = [&](int order) {
    double sum = cost(surface.front().column, surface.front().row, order);
    for (std::size_t i = 1; i < surface.size(); ++i) {
      const auto& [c, r, order_step] = surface[i];
      const double against = cost(c, r, order + order_step) - cost(c, r, own(c, r));
      sum += std::min(against, settings.most_evidence);
      if (orders(c, r) != order + order_step) sum += settings.disagreement;
    }
    return sum;
  };
  std::vector<int> candidates;
  for (const auto& [c, r, order_step] : surface) {
    const int implied = orders(c, r) - order_step;
    if (std::find(candidates.begin(), candidates.end(), implied) == candidates.end()) {
      candidates.push_back(implied);
    }
  }
  int best = candidates.front();
  double least = total(best);
  for (const int candidate : candidates) {
    const double here = candidate == best ? least : total(candidate);
    if (here < least) {
      best = candidate;
      least = here;
    }
  }
  return best;
}

/// Of the eight neighbours, those on the same surface that agree with `order` at the pixel.
int supporters(const std::vector<Neighbour>& surface, const Image<int>& orders, int order) {
  return static_cast<int>(
      std::count_if(surface.begin() + 1, surface.end(), [&](const Neighbour& neighbour) {
        return orders(neighbour.column, neighbour.row) == order + neighbour.order_step;
      }));
}

}  // namespace

void choose_with_neighbours(Image<int>& orders, const Image<double>& wrapped_phase,
                            const Image<std::uint8_t>& lit, const FringeOrderCost& cost,
                            const NeighbourhoodChoice& settings) {
  const Links links(wrapped_phase, lit, settings);
  const Image<int> own = orders;
  for (int pass = 0; pass < settings.passes; ++pass) {
    const Image<int> before = orders;
    for_each_row(orders.height(), [&](int row) {
      for (int column = 0; column < orders.width(); ++column) {
        if (!neighbours_disagree(links, before, column, row)) continue;
        const auto surface = same_surface(links, column, row, settings.radius);
        orders(column, row) = least_cost_order(surface, before, own, cost, settings);
      }
    });
  }
  for (int pass = 0; pass < settings.passes; ++pass) {
    const Image<int> before = orders;
    for_each_row(orders.height(), [&](int row) {
      for (int column = 0; column < orders.width(); ++column) {
        const int alone = own(column, row);
        if (before(column, row) == alone) continue;
        const auto surface = same_surface(links, column, row, 1);
        if (supporters(surface, before, alone) >= settings.hidden_edge) orders(column, row) = alone;
      }
    });
  }
}

}  // namespace slipstream
