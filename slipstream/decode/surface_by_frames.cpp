#include "slipstream/decode/surface_by_frames.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "slipstream/base/numbers.h"
#include "slipstream/decode/temporal_unwrapping.h"

namespace slipstream {
namespace {

class SurfaceByFrames {
 public:
  SurfaceByFrames(const Layout& layout, const LayoutPhases& phases)
      : frames_(phases.frames),
        measuring_(phases.bands.front()),
        periods_(layout.bands.front().periods),
        shown_(layout.single_frames) {}

  std::optional<int> operator()(const Surface& surface) const {
    int first = std::numeric_limits<int>::max(), last = std::numeric_limits<int>::min();
    surface.for_each([&](int, int, int order) {
      first = std::min(first, order);
      last = std::max(last, order);
    });
    constexpr std::size_t fewest = 2000;
    constexpr int least_span = 4;  // periods
    if (surface.pixels < fewest || last - first < least_span) return {};
    const int most = static_cast<int>(std::ceil(periods_)) - last;
    double least = std::numeric_limits<double>::infinity(), next = least;
    std::optional<int> best;
    for (int shift = -first - 1; shift <= most; ++shift) {
      const double left = misfit(surface, shift);
      if (left < least) {
        next = least;
        least = left;
        best = shift;
      } else {
        next = std::min(next, left);
      }
    }
    constexpr double most_left = 0.04, decided = 1.2;
    return least < most_left && next > decided * least ? best : std::nullopt;
  }

 private:
  /// The part of the frames' squares that is left.
  [[nodiscard]] double misfit(const Surface& surface, int shift) const {
    constexpr std::size_t every = 7;
    const std::size_t count = shown_.size();
    std::vector<double> squares(count), models(count), products(count);
    frames_.visit([&](const auto& frames) {
      std::size_t seen = 0;
      surface.for_each([&](int column, int row, int order) {
        if (seen++ % every != 0) return;
        const double y =
            unwrapped_coordinate(measuring_.wrapped_phase(column, row), order + shift, periods_);
        const double B = measuring_.modulation(column, row);
        for (std::size_t n = 0; n < count; ++n) {
          const auto& [frame, periods, origin] = shown_[n];
          const auto I = static_cast<double>(frames[static_cast<std::size_t>(frame)](column, row));
          const double model = B * (1 + std::cos(2 * std::numbers::pi * periods * y + origin));
          squares[n] += I * I;
          models[n] += model * model;
          products[n] += I * model;
        }
      });
    });
    double left = 0, all = 0;
    for (std::size_t n = 0; n < count; ++n) {
      all += squares[n];
      left += squares[n] - products[n] * products[n] / std::max(models[n], 1e-9);
    }
    return left / all;
  }

  const FrameViews& frames_;
  const PhaseMaps& measuring_;
  double periods_;
  const std::vector<SingleFrame>& shown_;
};

/// The order under which two bands agree: the mean of what the second's phase is off turns on by
/// the same angle from each order to the next.
class SurfaceByBands {
 public:
  SurfaceByBands(const Layout& layout, const LayoutPhases& phases)
      : first_(phases.bands[0].wrapped_phase),
        second_(phases.bands[1].wrapped_phase),
        periods_(layout.bands[0].periods),
        ratio_(layout.bands[1].periods / periods_) {}

  std::optional<int> operator()(const Surface& surface) const {
    constexpr double least_agreement = 0.9, decided = 2;
    int first = std::numeric_limits<int>::max(), last = std::numeric_limits<int>::min();
    std::complex<double> sum;
    surface.for_each([&](int column, int row, int order) {
      first = std::min(first, order);
      last = std::max(last, order);
      sum +=
          std::polar(1.0, ratio_ * (first_(column, row) + two_pi * order) - second_(column, row));
    });
    if (std::abs(sum) < least_agreement * static_cast<double>(surface.pixels)) return {};
    const double off = std::arg(sum);
    double least = std::numeric_limits<double>::infinity(), next = least;
    std::optional<int> best;
    for (int shift = -first - 1; shift <= static_cast<int>(std::ceil(periods_)) - last; ++shift) {
      const double left = std::abs(std::remainder(off + two_pi * ratio_ * shift, two_pi));
      if (left < least) best = shift;
      next = std::min(next, std::max(left, least));
      least = std::min(left, least);
    }
    return next > decided * least ? best : std::nullopt;
  }

 private:
  const Image<double>&first_, &second_;
  double periods_, ratio_;
};

}  // namespace

SurfaceChoice order_by_frames(const Layout& layout, const LayoutPhases& phases) {
  if (layout.bands.size() == 2) return SurfaceByBands(layout, phases);
  return SurfaceByFrames(layout, phases);
}

}  // namespace slipstream
