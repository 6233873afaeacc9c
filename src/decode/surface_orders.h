#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "slipstream/image.h"

namespace slipstream {

/// Pixels [first, last) of a row on one surface, whose fringe order is ConnectedSurface::orders +
/// `order`.
struct SurfaceRun {
  int row = 0, first = 0, last = 0, order = 0;
};

/// Pixels whose orders are known up to one number added to all.
struct ConnectedSurface {
  std::span<const SurfaceRun> runs;
  const Image<int>& orders;
  std::size_t pixels = 0;

  /// Calls `body(column, row, order)` for every pixel.
  template <class Body>
  void for_each(const Body& body) const {
    for (const auto& [row, first, last, order] : runs) {
      const int* const own = orders.row(row);
      for (int column = first; column < last; ++column) body(column, row, own[column] + order);
    }
  }
};

/// What to add to all orders of a surface; nullopt if ambiguous.
using SurfaceChoice = std::function<std::optional<int>(const ConnectedSurface& surface)>;

/// A second phase of the same pixels, with `ratio` times the periods of the first.
struct SecondPhase {
  Image<float> wrapped;
  float ratio = 1;
};

/// Fringe orders of a phase of many periods, surface by surface: on a surface the phase, and a
/// second phase if given, changes by less than a quarter of a period from pixel to pixel, so that
/// all orders are known up to one number. Reuses its memory.
class SurfaceOrders {
 public:
  static constexpr int none = std::numeric_limits<int>::min();

  /// The orders plus what `choose` returns for each surface; `none` where `wrapped_phase` (rad, [0,
  /// 2 pi]) is NaN, a surface has less than 64 pixels or `choose` returns nullopt.
  const Image<int>& operator()(const Image<float>& wrapped_phase, const SurfaceChoice& choose,
                               const SecondPhase* second = nullptr);

 private:
  void find_runs(const Image<float>& wrapped_phase, const SecondPhase* second);
  void join_rows(const Image<float>& wrapped_phase, const SecondPhase* second);
  void join(std::size_t run, std::size_t other, int further);
  std::size_t root_of(std::size_t run);

  std::vector<std::vector<SurfaceRun>> rows_;
  std::vector<SurfaceRun> runs_, sorted_;
  std::vector<std::size_t> parent_;  ///< another run of the surface, or itself
  std::vector<std::size_t> pixels_, place_;
  Image<int> orders_;
};

/// Possible fringe orders of a pixel, first to last; first > last for an empty range.
struct OrderRange {
  std::int16_t first = 0, last = -1;
};

/// Chooses the order for which 99.5 % of the pixels have a possible order, if any other gives at
/// least one in a hundred fewer. `possible` must outlive it.
SurfaceChoice by_possible_orders(const Image<OrderRange>& possible);

}  // namespace slipstream
