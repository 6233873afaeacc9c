#include "decode/surface_orders.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "decode/band_unwrapper.h"
#include "decode/decoder.h"
#include "decode/phase_decoder.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

/// Whole periods from a pixel's phase to the next one's; nullopt across an edge of either phase.
std::optional<int> periods_between(const Image<float>& phase, const SecondPhase* second, int column,
                                   int row, int next_column, int next_row) {
  constexpr auto pi = std::numbers::pi_v<float>;
  constexpr float steepest = 0.5F * pi;  // per pixel

  const float step = phase(next_column, next_row) - phase(column, row);
  const int whole = step > pi ? 1 : step < -pi ? -1 : 0;
  const float rest = step - 2 * pi * static_cast<float>(whole);

  if (!(std::abs(rest) < steepest)) return std::nullopt;
  if (second == nullptr) return whole;

  // rad. Smoothed phases continue across an edge, but by unequal steps.
  constexpr float most = 0.04F;
  const float seen = second->wrapped(next_column, next_row) - second->wrapped(column, row);
  const bool alike = std::abs(std::remainder(seen - second->ratio * rest, 2 * pi)) < most;
  return alike ? std::optional(whole) : std::nullopt;
}

/// Counts the pixels with a possible order for each shift of a surface's orders.
class Votes {
 public:
  void add(int first, int last) {
    if (first > last) return;
    if (changes_.empty()) first_ = first;

    // Make room at either end.
    if (first < first_) {
      changes_.insert(changes_.begin(), static_cast<std::size_t>(first_ - first), 0);
      first_ = first;
    }
    const auto end = static_cast<std::size_t>(last - first_ + 1);
    if (end >= changes_.size()) changes_.resize(end + 1);

    // Note only where a range begins and ends: running sums then give the votes.
    ++changes_[first - first_];
    --changes_[end];
  }

  /// nullopt if no shift is certain.
  [[nodiscard]] std::optional<int> chosen(std::size_t pixels) {
    constexpr double least = 0.995, most_other = 0.99;
    if (changes_.empty()) return {};

    // Votes of each shift.
    std::vector<int>& counts = changes_;
    std::partial_sum(counts.begin(), counts.end(), counts.begin());

    // Nearly all pixels must allow it, and no other shift nearly as often.
    const auto best = std::max_element(counts.begin(), counts.end());
    if (*best < least * static_cast<double>(pixels)) return {};

    const auto near = std::count_if(counts.begin(), counts.end(),
                                    [&](int others) { return others > most_other * *best; });
    if (near > 1) return {};
    return first_ + static_cast<int>(best - counts.begin());
  }

 private:
  int first_ = 0;
  std::vector<int> changes_;  ///< from each shift to the next
};

/// The fraction of the single frames' sum of squares that remains with `shift`.
double misfit(const Layout& layout, const LayoutPhases& phases, const ConnectedSurface& surface,
              int shift) {
  constexpr std::size_t every = 7;

  const PhaseMaps& measuring = phases.bands.front();
  const std::vector<SingleFrame>& shown = layout.single_frames;
  const std::size_t count = shown.size();

  std::vector<double> squares(count), models(count), products(count);

  phases.frames.visit([&](const auto& frames) {
    std::size_t seen = 0;
    surface.for_each([&](int column, int row, int order) {
      if (seen++ % every != 0) return;
      const double y = unwrapped_coordinate(measuring.wrapped_phase(column, row), order + shift,
                                            layout.bands.front().periods);
      const double B = measuring.modulation(column, row);

      for (std::size_t n = 0; n < count; ++n) {
        const auto& [frame, periods, origin] = shown[n];
        const auto I = static_cast<double>(frames[frame](column, row));
        const double model = B * (1 + std::cos(two_pi * periods * y + origin));
        squares[n] += I * I;
        models[n] += model * model;
        products[n] += I * model;
      }
    });
  });

  // Each frame has a factor of its own, by least squares.
  double left = 0, all = 0;
  for (std::size_t n = 0; n < count; ++n) {
    all += squares[n];
    left += squares[n] - products[n] * products[n] / std::max(models[n], 1e-9);
  }

  return left / all;
}

/// First and last of a surface's own orders.
std::pair<int, int> order_range(const ConnectedSurface& surface) {
  int first = std::numeric_limits<int>::max(), last = std::numeric_limits<int>::min();

  surface.for_each([&](int, int, int order) {
    first = std::min(first, order);
    last = std::max(last, order);
  });

  return {first, last};
}

/// The shift with the least residual, of all that keep the orders near the field; with that
/// residual and the next best.
struct BestShift {
  std::optional<int> shift{};
  double least = std::numeric_limits<double>::infinity(), next = least;
};

template <class Left>
BestShift best_shift(std::pair<int, int> orders, double periods, const Left& left_by) {
  BestShift best;

  // All orders must lie in the field, or at most one beyond either end.
  const int most = static_cast<int>(std::ceil(periods)) - orders.second;
  for (int shift = -orders.first - 1; shift <= most; ++shift) {
    const double left = left_by(shift);
    if (left < best.least) {
      best = {shift, left, best.least};
    } else {
      best.next = std::min(best.next, left);
    }
  }

  return best;
}

SurfaceChoice by_single_frames(const Layout& layout, const LayoutPhases& phases) {
  return [&](const ConnectedSurface& surface) -> std::optional<int> {
    constexpr std::size_t fewest = 2000;
    constexpr int least_span = 4;  // periods
    constexpr double most_left = 0.04, decided = 1.2;

    const std::pair orders = order_range(surface);
    if (surface.pixels < fewest || orders.second - orders.first < least_span) return {};

    const auto [shift, least, next] =
        best_shift(orders, layout.bands.front().periods,
                   [&](int tried) { return misfit(layout, phases, surface, tried); });

    return least < most_left && next > decided * least ? shift : std::nullopt;
  };
}

/// The order for which two bands agree: the mean deviation of the second's phase rotates by the
/// same angle from each order to the next.
SurfaceChoice by_two_bands(const Layout& layout, const LayoutPhases& phases) {
  return [&](const ConnectedSurface& surface) -> std::optional<int> {
    constexpr double least_agreement = 0.9, decided = 2;

    const double periods = layout.bands[0].periods, ratio = layout.bands[1].periods / periods;
    const auto &first = phases.bands[0].wrapped_phase, &second = phases.bands[1].wrapped_phase;

    std::complex<double> sum;
    surface.for_each([&](int column, int row, int order) {
      sum += std::polar(1.0, ratio * (first(column, row) + two_pi * order) - second(column, row));
    });

    // The second phase must deviate by the same angle everywhere.
    if (std::abs(sum) < least_agreement * static_cast<double>(surface.pixels)) return {};

    const double off = std::arg(sum);
    const auto [shift, least, next] = best_shift(order_range(surface), periods, [&](int tried) {
      return std::abs(std::remainder(off + two_pi * ratio * tried, two_pi));
    });

    return next > decided * least ? shift : std::nullopt;
  };
}

}  // namespace

void SurfaceOrders::find_runs(const Image<float>& wrapped_phase, const SecondPhase* second) {
  const auto [width, height] = wrapped_phase.size();
  if (orders_.size() != wrapped_phase.size()) orders_ = Image<int>(wrapped_phase.size());

  rows_.resize(static_cast<std::size_t>(height));
  for_each_row(height, [&, width = width](int row) {
    std::vector<SurfaceRun>& runs = rows_[row];
    runs.clear();

    const float* const phase = wrapped_phase.row(row);
    int* const orders = orders_.row(row);
    for (int column = 0; column < width; ++column) {
      orders[column] = none;
      if (!std::isfinite(phase[column])) continue;

      // Continue the run unless an edge lies before this pixel.
      orders[column] = 0;
      std::optional<int> whole;
      if (column > 0) whole = periods_between(wrapped_phase, second, column - 1, row, column, row);

      if (whole) {
        orders[column] = orders[column - 1] - *whole;
        ++runs.back().last;
      } else {
        runs.push_back({.row = row, .first = column, .last = column + 1, .order = 0});
      }
    }
  });
}

std::size_t SurfaceOrders::root_of(std::size_t run) {
  // Shorten the path on the way: each run is then relative to a run nearer to the root.
  while (parent_[run] != run) {
    const std::size_t next = parent_[run];
    if (parent_[next] == next) return next;

    runs_[run].order += runs_[next].order;
    parent_[run] = parent_[next];
  }

  return run;
}

/// `further`: order offset of `other` relative to `run` where they touch.
void SurfaceOrders::join(std::size_t run, std::size_t other, int further) {
  const std::size_t root = root_of(run), joined = root_of(other);
  if (root == joined) return;

  const auto order_of = [&](std::size_t of, std::size_t its_root) {
    return of == its_root ? 0 : runs_[of].order;
  };

  parent_[joined] = root;
  runs_[joined].order = order_of(run, root) + further - order_of(other, joined);
}

void SurfaceOrders::join_rows(const Image<float>& wrapped_phase, const SecondPhase* second) {
  runs_.clear();

  std::size_t above = 0, end = 0;
  for (const std::vector<SurfaceRun>& row : rows_) {
    // Append the row's runs, each a surface of its own so far.
    const std::size_t begin = runs_.size();
    runs_.insert(runs_.end(), row.begin(), row.end());
    parent_.resize(runs_.size());
    std::iota(parent_.begin() + static_cast<std::ptrdiff_t>(begin), parent_.end(), begin);

    // Compare with the runs above wherever they overlap.
    end = begin;
    for (std::size_t run = begin; above < end && run < runs_.size();) {
      const int first = std::max(runs_[above].first, runs_[run].first);
      const int last = std::min(runs_[above].last, runs_[run].last);
      const int below = runs_[run].row;

      for (int column = first; column < last; ++column) {
        const auto whole = periods_between(wrapped_phase, second, column, below - 1, column, below);
        if (!whole) continue;
        join(above, run, orders_(column, below - 1) - *whole - orders_(column, below));
        break;
      }

      // Go on with the run that ends first.
      if (runs_[above].last < runs_[run].last) {
        ++above;
      } else {
        ++run;
      }
    }

    above = begin;
  }
}

const Image<int>& SurfaceOrders::operator()(const Image<float>& wrapped_phase,
                                            const SurfaceChoice& choose,
                                            const SecondPhase* second) {
  constexpr std::size_t fewest = 64;

  // 1. Runs along rows, joined to surfaces.
  find_runs(wrapped_phase, second);
  join_rows(wrapped_phase, second);

  // 2. Orders relative to the surface, and the runs sorted by surface: each root counts the pixels
  // and runs of its own.
  pixels_.assign(runs_.size(), 0);
  place_.assign(runs_.size() + 1, 0);
  for (std::size_t run = 0; run < runs_.size(); ++run) {
    const std::size_t root = root_of(run);
    parent_[run] = root;
    pixels_[root] += static_cast<std::size_t>(runs_[run].last - runs_[run].first);
    ++place_[root + 1];
  }

  std::partial_sum(place_.begin(), place_.end(), place_.begin());

  sorted_.resize(runs_.size());
  for (std::size_t run = 0; run < runs_.size(); ++run) {
    const std::size_t root = parent_[run];
    if (root == run) runs_[run].order = 0;
    sorted_[place_[root]++] = runs_[run];
  }

  // 3. One shift for all orders of a surface, if any is certain.
  std::size_t begin = 0;
  for (std::size_t root = 0; root < runs_.size(); ++root) {
    const std::size_t end = place_[root];
    const ConnectedSurface surface{{sorted_.data() + begin, end - begin}, orders_, pixels_[root]};
    begin = end;
    if (surface.runs.empty()) continue;

    const auto shift = surface.pixels < fewest ? std::nullopt : choose(surface);
    for (const auto& [row, first, last, order] : surface.runs) {
      int* const orders = orders_.row(row);
      for (int column = first; column < last; ++column) {
        orders[column] = shift ? orders[column] + order + *shift : none;
      }
    }
  }

  return orders_;
}

SurfaceChoice by_possible_orders(const Image<OrderRange>& possible) {
  return [&possible](const ConnectedSurface& surface) {
    Votes votes;
    surface.for_each([&](int column, int row, int order) {
      const auto [first, last] = possible(column, row);
      votes.add(first - order, last - order);
    });
    return votes.chosen(surface.pixels);
  };
}

UnwrappedPhases unwrap_by_surfaces(const Layout& layout, const LayoutPhases& phases,
                                   double least_modulation) {
  const PhaseMaps& band = phases.bands.front();
  const Size size = band.wrapped_phase.size();

  Image<float> phase(size);
  std::transform(
      band.wrapped_phase.begin(), band.wrapped_phase.end(), band.modulation.begin(), phase.begin(),
      [&](double phi, double B) { return static_cast<float>(B > least_modulation ? phi : nan); });

  // A second band's phase tells surfaces apart where the first continues across an edge.
  const double periods = layout.bands.front().periods;
  SecondPhase second;
  const bool two = layout.bands.size() == 2;
  if (two) {
    second.ratio = static_cast<float>(layout.bands[1].periods / periods);
    convert(phases.bands[1].wrapped_phase, second.wrapped);
  }

  // Orders surface by surface.
  SurfaceOrders by_surfaces;
  const Image<int>& orders =
      by_surfaces(phase, two ? by_two_bands(layout, phases) : by_single_frames(layout, phases),
                  two ? &second : nullptr);

  UnwrappedPhases result{.coordinate = Image<double>(size, nan), .doubt = Image<double>(size, 0.5)};

  // Coordinates, except where a second band contradicts them.
  for_each_pixel(size, [&](int column, int row) {
    const int order = orders(column, row);
    if (order == SurfaceOrders::none) return;

    const double y = unwrapped_coordinate(band.wrapped_phase(column, row), order, periods);
    if (two) {
      constexpr double most = 0.125;  // periods
      const double turns = phases.bands[1].wrapped_phase(column, row) / two_pi;
      if (std::abs(std::remainder(layout.bands[1].periods * y - turns, 1)) > most) return;
    }

    result.coordinate(column, row) = y;
    result.doubt(column, row) = 0;
  });

  return result;
}

}  // namespace slipstream
