#include "slipstream/decode/neighbourhood_fringe_order.h"

#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

namespace slipstream {
namespace {

/// Whole images, as NeighbourhoodVote looks at them.
class ImageField {
 public:
  ImageField(const Image<int>& own, const Image<double>& wrapped_phase,
             const Image<std::uint8_t>& lit, const FringeOrderCost& cost)
      : own_(own), phase_(wrapped_phase), lit_(lit), cost_(cost), shift_(own.size()) {}

  [[nodiscard]] double periods(int column, int row) const {
    if (!inside(column, row) || lit_(column, row) == 0)
      return std::numeric_limits<double>::quiet_NaN();
    return phase_(column, row) / (2 * std::numbers::pi) + own_(column, row);
  }
  void periods_around(int column, int row, PhaseWindow& window) const {
    for (int r = 0; r < 9; ++r) {
      for (int c = 0; c < 9; ++c) {
        window.periods[static_cast<std::size_t>(r) * PhaseWindow::line +
                       static_cast<std::size_t>(c)] =
            static_cast<float>(periods(column + c - 4, row + r - 4) - periods(column, row));
      }
    }
  }
  static void foresee(const std::vector<PixelPlace>&) {}
  struct Window {
    const ImageField& field;
    int column = 0, row = 0;  ///< of its first pixel

    [[nodiscard]] double against(int cell, int shift) const {
      const int c = column + cell % 5, r = row + cell / 5, own = field.own_(c, r);
      return field.cost_(c, r, own + shift) - field.cost_(c, r, own);
    }
    [[nodiscard]] int shift(int line, int place) const {
      const int c = column + place, r = row + line;
      return field.inside(c, r) ? field.shift_(c, r) : 0;
    }
  };
  [[nodiscard]] Window window_around(int column, int row) const {
    return {*this, column - 2, row - 2};
  }
  [[nodiscard]] static bool own_order_costs_least() { return false; }
  [[nodiscard]] int shift(int column, int row) const { return shift_(column, row); }
  void set_shift(int column, int row, int shift) { shift_(column, row) = shift; }

 private:
  [[nodiscard]] bool inside(int column, int row) const {
    return column >= 0 && row >= 0 && column < lit_.width() && row < lit_.height();
  }

  const Image<int>& own_;
  const Image<double>& phase_;
  const Image<std::uint8_t>& lit_;
  const FringeOrderCost& cost_;
  Image<int> shift_;
};

}  // namespace

void choose_with_neighbours(Image<int>& orders, const Image<double>& wrapped_phase,
                            const Image<std::uint8_t>& lit, const FringeOrderCost& cost) {
  ImageField field(orders, wrapped_phase, lit, cost);
  NeighbourhoodVote vote(field);
  Image<std::uint8_t> open(orders.size());
  for_each_row(orders.height(), [&](int row) {
    for (int column = 0; column < orders.width(); ++column) {
      open(column, row) = vote.disagrees(column, row) ? 1 : 0;
    }
  });
  NeighbourhoodVoteLists lists;
  for (int row = 0; row < orders.height(); ++row) {
    for (int column = 0; column < orders.width(); ++column) {
      if (open(column, row) != 0) lists.open.push_back({row, column});
    }
  }
  vote(lists);
  for (const auto& [row, column] : lists.ever_moved) {
    orders(column, row) += field.shift(column, row);
  }
}

}  // namespace slipstream
