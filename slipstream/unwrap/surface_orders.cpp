#include "slipstream/unwrap/surface_orders.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "slipstream/unwrap/temporal_unwrapping.h"

namespace slipstream {
namespace {

using std::numbers::pi;

/// Flooded from one of its pixels, whose order is 0.
class Surfaces {
 public:
  explicit Surfaces(const Image<double>& wrapped_phase)
      : wrapped_phase_(wrapped_phase), reached_(wrapped_phase.size()) {}

  /// The surface of a pixel that no other has yet; none where it has no phase.
  const std::vector<SurfacePixel>& flood(int column, int row) {
    pixels_.clear();
    if (reached_(column, row) != 0 || !std::isfinite(wrapped_phase_(column, row))) return pixels_;
    add({column, row, 0});
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const SurfacePixel from = pixels_[i];
      reach(from, from.column + 1, from.row);
      reach(from, from.column - 1, from.row);
      reach(from, from.column, from.row + 1);
      reach(from, from.column, from.row - 1);
    }
    return pixels_;
  }

 private:
  void add(SurfacePixel pixel) {
    reached_(pixel.column, pixel.row) = 1;
    pixels_.push_back(pixel);
  }

  void reach(SurfacePixel from, int column, int row) {
    constexpr double steepest = 0.5 * pi;  // per pixel
    const auto [width, height] = reached_.size();
    if (column < 0 || row < 0 || column >= width || row >= height) return;
    if (reached_(column, row) != 0) return;
    const double step = wrapped_phase_(column, row) - wrapped_phase_(from.column, from.row);
    const int whole = step > pi ? 1 : step < -pi ? -1 : 0;
    if (std::abs(step - 2 * pi * whole) < steepest) add({column, row, from.order - whole});
  }

  const Image<double>& wrapped_phase_;
  Image<std::uint8_t> reached_;
  std::vector<SurfacePixel> pixels_;
};

/// How many pixels may have their order by each shift of all the orders of a surface.
class Votes {
 public:
  void add(int first, int last) {
    if (first > last) return;
    if (counts_.empty()) first_ = first;
    if (first < first_) {
      counts_.insert(counts_.begin(), static_cast<std::size_t>(first_ - first), 0);
      first_ = first;
    }
    const auto end = static_cast<std::size_t>(last - first_ + 1);
    if (end > counts_.size()) counts_.resize(end);
    for (auto i = static_cast<std::size_t>(first - first_); i < end; ++i) ++counts_[i];
  }

  /// None where no shift is sure.
  [[nodiscard]] std::optional<int> chosen(std::size_t pixels) const {
    constexpr double least = 0.995, most_other = 0.99;
    const auto best = std::max_element(counts_.begin(), counts_.end());
    if (best == counts_.end()) return {};
    const auto count = static_cast<double>(*best);
    if (count < least * static_cast<double>(pixels)) return {};
    const auto near = std::count_if(counts_.begin(), counts_.end(), [&](std::size_t others) {
      return static_cast<double>(others) > most_other * count;
    });
    if (near > 1) return {};
    return first_ + static_cast<int>(best - counts_.begin());
  }

 private:
  int first_ = 0;
  std::vector<std::size_t> counts_;
};

}  // namespace

Image<double> coordinate_by_surfaces(const Image<double>& wrapped_phase, double periods,
                                     const SurfaceChoice& choose) {
  constexpr std::size_t fewest = 64;
  Image<double> coordinate(wrapped_phase.size(), std::numeric_limits<double>::quiet_NaN());
  Surfaces surfaces(wrapped_phase);
  for (int row = 0; row < coordinate.height(); ++row) {
    for (int column = 0; column < coordinate.width(); ++column) {
      const std::vector<SurfacePixel>& surface = surfaces.flood(column, row);
      if (surface.size() < fewest) continue;
      const std::optional<int> shift = choose(surface);
      if (!shift) continue;
      for (const auto& [x, y, order] : surface) {
        coordinate(x, y) = unwrapped_coordinate(wrapped_phase(x, y), order + *shift, periods);
      }
    }
  }
  return coordinate;
}

SurfaceChoice by_possible_orders(const Image<OrderRange>& possible) {
  return [&possible](const std::vector<SurfacePixel>& surface) {
    Votes votes;
    for (const auto& [column, row, order] : surface) {
      const auto [first, last] = possible(column, row);
      votes.add(first - order, last - order);
    }
    return votes.chosen(surface.size());
  };
}

}  // namespace slipstream
