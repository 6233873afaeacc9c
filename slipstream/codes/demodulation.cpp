#include "slipstream/codes/demodulation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <random>
#include <unordered_set>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

using Symbols = std::vector<std::uint8_t>;

/// So many symbols that no window comes twice: each one that may follow, in a mixed order, and a
/// step back where none is left. `window` is what ends with the last symbol, where one does.
template <class Following, class Window>
Symbols without_repeats(std::size_t count, const Following& following, const Window& window) {
  Symbols found;
  std::vector<Symbols> left;  // to be tried, for each symbol and the next
  std::unordered_set<int> seen;
  std::minstd_rand random;
  while (found.size() < count) {
    if (left.size() == found.size()) {
      Symbols next = following(found);
      for (std::size_t i = next.size(); i > 1; --i) std::swap(next[i - 1], next[random() % i]);
      left.push_back(std::move(next));
    }
    if (left.back().empty()) {
      left.pop_back();
      if (const std::optional<int> last = window(found)) seen.erase(*last);
      found.pop_back();
      continue;
    }
    found.push_back(left.back().back());
    left.back().pop_back();
    const std::optional<int> key = window(found);
    if (key && !seen.insert(*key).second) found.pop_back();
  }
  return found;
}

constexpr int least = 8;

}  // namespace

SymbolGrid coloured_stripes(int stripes) {
  constexpr int most = 256;
  if (stripes < least || stripes > most) {
    throw Error(fmt::format("{} stripes are out of range; {} to {}", stripes, least, most));
  }
  const auto following = [](const Symbols& found) {
    Symbols next;
    for (std::uint8_t colour = 1; colour < 7; ++colour) {
      if (found.empty() || (colour != found.back() && (colour & found.back()) != 0)) {
        next.push_back(colour);
      }
    }
    return next;
  };
  const auto window = [](const Symbols& found) -> std::optional<int> {
    if (found.size() <= stripe_window) return std::nullopt;
    int key = 0;
    for (std::size_t i = found.size() - stripe_window; i < found.size(); ++i) {
      for (unsigned c = 0; c < 3; ++c) {
        key = 3 * key + 1 + ((found[i] >> c) & 1) - ((found[i - 1] >> c) & 1);
      }
    }
    return key;
  };
  return {stripes, without_repeats(static_cast<std::size_t>(stripes), following, window)};
}

SymbolGrid symbol_array(int columns, int rows) {
  constexpr int most = 4096;
  if (columns < least || rows < least || columns > most / rows) {
    throw Error(
        fmt::format("{} columns and {} rows are out of range; {} or more each, {} at most "
                    "in all",
                    columns, rows, least, most));
  }
  const auto width = static_cast<std::size_t>(columns);
  const auto window = [width](const Symbols& found) -> std::optional<int> {
    constexpr std::size_t before = symbol_window - 1;
    const std::size_t last = found.size() - 1;
    if (last / width < before || last % width < before) return std::nullopt;
    int key = 0;
    for (std::size_t row = 0; row < symbol_window; ++row) {
      for (std::size_t column = 0; column < symbol_window; ++column) {
        key = 3 * key + found[last - before * (width + 1) + row * width + column];
      }
    }
    return key;
  };
  const auto following = [](const Symbols&) { return Symbols{0, 1, 2}; };
  return {columns, without_repeats(width * static_cast<std::size_t>(rows), following, window)};
}

double symbol_shape(int symbol, double along, double across) {
  constexpr double half = 0.32, longer = 0.48, shorter = 0.18;
  const auto bump = [](double at, double reach) {
    return std::abs(at) < reach ? 0.5 + 0.5 * std::cos(std::numbers::pi * at / reach) : 0;
  };
  return bump(along, symbol == 0   ? half
                     : symbol == 1 ? longer
                                   : shorter) *
         bump(across, symbol == 0   ? half
                      : symbol == 1 ? shorter
                                    : longer);
}

double grid_intensity(const SymbolGrid& grid, int n, double y, double across) {
  const auto place = [](double at, int count) {
    return std::clamp(static_cast<int>(std::floor(at)), 0, count - 1);
  };
  const auto symbol = [&](int column, int row) {
    return grid.symbols[static_cast<std::size_t>(row * grid.columns + column)];
  };
  if (grid.rows() > 1) {
    const double u = y * grid.columns, v = across * grid.rows();
    const int column = place(u, grid.columns), row = place(v, grid.rows());
    return symbol_shape(symbol(column, row), u - column - 0.5, v - row - 0.5);
  }
  const auto level = [&](int stripe) {
    return (symbol(place(stripe, grid.columns), 0) >> static_cast<unsigned>(n)) & 1;
  };
  const double x = y * grid.columns - 0.5;
  const int stripe = static_cast<int>(std::floor(x));
  const double share = 0.5 - 0.5 * std::cos(std::numbers::pi * (x - stripe));
  return level(stripe) + (level(stripe + 1) - level(stripe)) * share;
}

using std::numbers::pi;

std::vector<SpectralFrame> sine_cosine_mean(double periods, double share) {
  using Kind = SpectralFrame::Kind;
  const SpectralFrame cosine{.kind = Kind::sinusoid, .periods = periods, .share = share};
  SpectralFrame sine = cosine, mean = cosine;
  sine.angle = pi / 2;
  mean.kind = Kind::mean;
  return {sine, cosine, mean};
}

Band sine_cosine_mean_band(int frames, int first, double periods, const Shifts& shifts) {
  const auto count = static_cast<std::size_t>(frames), sine = static_cast<std::size_t>(first);
  const double turn = shifts.backwards ? -1 : 1;
  const double c = 2 * std::cos(shifts.origin), s = 2 * std::sin(shifts.origin);
  Band band{.periods = periods,
            .cosine = std::vector<double>(count),
            .sine = std::vector<double>(count),
            .mean = std::vector<double>(count)};
  // Each frame less the mean.
  const auto weigh = [&](std::vector<double>& weights, double of_sine, double of_cosine) {
    weights[sine] = of_sine;
    weights[sine + 1] = of_cosine;
    weights[sine + 2] = -(of_sine + of_cosine);
  };
  weigh(band.cosine, turn * s, c);
  weigh(band.sine, turn * c, -s);
  band.mean[sine + 2] = 1;
  return band;
}

double sine_cosine_mean_shape(int n, double periods, double y, const Shifts& shifts) {
  const double phase = 2 * pi * periods * y + shifts.origin;
  if (n == 0) return 0.5 + (shifts.backwards ? -0.25 : 0.25) * std::sin(phase);
  return n == 1 ? 0.5 + 0.25 * std::cos(phase) : 0.5;
}

}  // namespace slipstream
