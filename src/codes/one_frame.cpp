#include "slipstream/one_frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <unordered_set>
#include <vector>

#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

using std::numbers::pi;

using Symbols = std::vector<std::uint8_t>;

/// Finds `count` symbols without a repeated window, by backtracking over the next symbols in random
/// order. `window` encodes the window that ends at the last symbol, if complete.
template <class Following, class Window>
Symbols without_repeats(std::size_t count, const Following& following, const Window& window) {
  Symbols found;
  std::vector<Symbols> left;  // next symbols still to try, at each position
  std::unordered_set<int> seen;
  std::minstd_rand random;

  while (found.size() < count) {
    // A new position: all symbols that may follow, in random order.
    if (left.size() == found.size()) {
      Symbols next = following(found);
      for (std::size_t i = next.size(); i > 1; --i) std::swap(next[i - 1], next[random() % i]);
      left.push_back(std::move(next));
    }

    // If all have failed, go back by one position.
    if (left.back().empty()) {
      left.pop_back();
      if (const std::optional<int> last = window(found)) seen.erase(*last);
      found.pop_back();
      continue;
    }

    // Try the next one, and take it back if its window has occurred before.
    found.push_back(left.back().back());
    left.back().pop_back();
    const std::optional<int> key = window(found);
    if (key && !seen.insert(*key).second) found.pop_back();
  }

  return found;
}

constexpr int least = 8;

/// 0: round, 1: elongated along the axis, 2: across it. Intensity in [0, 1] at a position in its
/// cell, -0.5 to 0.5.
double symbol_shape(int symbol, double along, double across) {
  constexpr std::array along_reach{0.32, 0.48, 0.18}, across_reach{0.32, 0.18, 0.48};
  // A raised cosine within its reach, dark beyond.
  const auto bump = [&](double at, const auto& reach) {
    return std::abs(at) < reach[symbol] ? 0.5 + 0.5 * std::cos(pi * at / reach[symbol]) : 0;
  };

  return bump(along, along_reach) * bump(across, across_reach);
}

}  // namespace

SymbolGrid coloured_stripes(int stripes) {
  constexpr int most = 256;
  throw_if(stripes < least || stripes > most, "{} stripes are out of range; {} to {}", stripes,
           least, most);

  // Colours 1 to 6 light one or two of the three channels; neighbours share at least one.
  const auto following = [](const Symbols& found) {
    Symbols next;
    for (std::uint8_t colour = 1; colour < 7; ++colour) {
      if (found.empty() || (colour != found.back() && (colour & found.back()) != 0)) {
        next.push_back(colour);
      }
    }
    return next;
  };

  // The window as a number in base 3: a transition turns a channel off, leaves it or turns it on.
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

  return {stripes, without_repeats(stripes, following, window)};
}

SymbolGrid symbol_array(int columns, int rows) {
  constexpr int most = 4096;
  throw_if(columns < least || rows < least || columns > most / rows,
           "{} columns and {} rows are out of range; at least {} each, at most {} symbols in total",
           columns, rows, least, most);

  // The square that ends at the last symbol, as a number in base 3.
  const auto window = [columns](const Symbols& found) -> std::optional<int> {
    constexpr std::size_t before = symbol_window - 1;
    const std::size_t last = found.size() - 1;
    if (last / columns < before || last % columns < before) return std::nullopt;

    int key = 0;
    for (std::size_t row = 0; row < symbol_window; ++row) {
      for (std::size_t column = 0; column < symbol_window; ++column) {
        key = 3 * key + found[last - before * (columns + 1) + row * columns + column];
      }
    }

    return key;
  };

  const auto following = [](const Symbols&) { return Symbols{0, 1, 2}; };
  return {columns, without_repeats(columns * rows, following, window)};
}

double grid_intensity(const SymbolGrid& grid, int n, double y, double across) {
  const auto place = [](double at, int count) {
    return std::clamp(static_cast<int>(std::floor(at)), 0, count - 1);
  };

  const auto symbol = [&](int column, int row) {
    return grid.symbols[row * grid.columns + column];
  };

  // Symbols: the one whose cell contains the position.
  if (grid.rows() > 1) {
    const double u = y * grid.columns, v = across * grid.rows();
    const int column = place(u, grid.columns), row = place(v, grid.rows());
    return symbol_shape(symbol(column, row), u - column - 0.5, v - row - 0.5);
  }

  // Stripes: a cosine slope from the centre of each to the centre of the next.
  const auto level = [&](int stripe) {
    return (symbol(place(stripe, grid.columns), 0) >> static_cast<unsigned>(n)) & 1;
  };

  const double x = y * grid.columns - 0.5;
  const int stripe = static_cast<int>(std::floor(x));
  const double share = 0.5 - 0.5 * std::cos(pi * (x - stripe));

  return level(stripe) + (level(stripe + 1) - level(stripe)) * share;
}

std::vector<SpectralFrame> sine_cosine_mean(double periods, double share) {
  using Kind = SpectralFrame::Kind;
  const SpectralFrame cosine{.kind = Kind::sinusoid, .periods = periods, .share = share};

  SpectralFrame sine = cosine, mean = cosine;
  sine.angle = pi / 2;
  mean.kind = Kind::mean;

  return {sine, cosine, mean};
}

Band sine_cosine_mean_band(int frames, int first, double periods, const Shifts& shifts) {
  const double turn = shifts.backwards ? -1 : 1;
  // The factor 2: these frames show only half of B.
  const double c = 2 * std::cos(shifts.origin), s = 2 * std::sin(shifts.origin);

  const std::vector<double> none(frames);
  Band band{.periods = periods, .cosine = none, .sine = none, .mean = none};

  // Each frame minus the mean.
  const auto weigh = [&](std::vector<double>& weights, double of_sine, double of_cosine) {
    weights[first] = of_sine;
    weights[first + 1] = of_cosine;
    weights[first + 2] = -(of_sine + of_cosine);
  };

  weigh(band.cosine, turn * s, c);
  weigh(band.sine, turn * c, -s);
  band.mean[first + 2] = 1;

  return band;
}

double sine_cosine_mean_shape(int n, double periods, double y, const Shifts& shifts) {
  const double phase = 2 * pi * periods * y + shifts.origin;
  if (n == 0) return 0.5 + (shifts.backwards ? -0.25 : 0.25) * std::sin(phase);
  return n == 1 ? 0.5 + 0.25 * std::cos(phase) : 0.5;
}

void FourierProfilometry::require_valid() const {
  slipstream::require_valid(Sinusoid{.frequency = frequency}, "fourier");

  constexpr double fewest = 8;  // periods; fewer are too few for a carrier
  throw_if(frequency < fewest, "fourier: frequency {} is out of range; {} or more", frequency,
           fewest);

  // Above it, a carrier is too near to the other or its harmonics.
  constexpr double largest = 0.45;  // of the frequency
  if (low && !(*low >= fewest && *low <= largest * frequency)) {
    throw Error(fmt::format("fourier: low {} is out of range; {} to {} times the frequency", *low,
                            fewest, largest));
  }
}

double FourierProfilometry::shape(int n, double y) const {
  const double intensity = sinusoid_intensity({2, frequency, shifts}, n, y);
  return low ? (intensity + sinusoid_intensity({2, *low, shifts}, n, y)) / 2 : intensity;
}

Demodulation FourierProfilometry::demodulation() const {
  Demodulation how{.shown = pi_shift ? 2 : 1, .frames = sine_cosine_mean(frequency, low ? 0.5 : 1)};
  if (low) {
    for (const SpectralFrame& frame : sine_cosine_mean(*low, 0.5)) how.frames.push_back(frame);
  }
  return how;
}

double FourierProfilometry::read_shape(int n, double y) const {
  return sine_cosine_mean_shape(n % 3, n < 3 ? frequency : *low, y, shifts);
}

Layout FourierProfilometry::layout() const {
  if (!low) return {.frames = 3, .bands = {sine_cosine_mean_band(3, 0, frequency, shifts)}};

  return {.frames = 6,
          .bands = {sine_cosine_mean_band(6, 0, frequency, shifts),
                    sine_cosine_mean_band(6, 3, *low, shifts)},
          .unwrapping = Unwrapping::surfaces};
}

void CompositePattern::require_valid() const {
  constexpr double fewest = 8;  // periods; fewer are too few for a carrier
  constexpr std::size_t most_carriers = 8;

  slipstream::require_valid(Sinusoid{steps(), low}, "composite");
  slipstream::require_valid(Sinusoid{.frequency = high}, "composite");

  const bool spread = std::ranges::all_of(
      carriers, [&](double periods) { return periods >= fewest && std::isfinite(periods); });
  throw_if(!(high >= fewest) || !spread || carriers.size() > most_carriers,
           "composite: high and carriers must have {} or more periods; 3 to {} carriers", fewest,
           most_carriers);

  throw_if(!(share > 0 && share < 1), "composite: share {} is out of range; above 0, below 1",
           share);
}

double CompositePattern::shape(int, double y, double across) const {
  // The sinusoid that measures.
  double sum = share * std::cos(2 * pi * high * y);

  // The low frequency's patterns, each on its own carrier.
  for (int n = 0; n < steps(); ++n) {
    const double carrier = std::cos(2 * pi * carriers[n] * across);
    sum += (1 - share) / steps() * read_shape(n, y) * carrier;
  }

  return 0.5 + 0.5 * sum;
}

Demodulation CompositePattern::demodulation() const {
  using Kind = SpectralFrame::Kind;
  Demodulation how{.shown = 1, .frames = {}};

  // One pattern of the low frequency from each carrier, then the sinusoid that measures.
  for (const double periods : carriers) {
    how.frames.push_back({.kind = Kind::envelope,
                          .periods = periods,
                          .across = true,
                          .share = (1 - share) / steps()});
  }
  for (const SpectralFrame& frame : sine_cosine_mean(high, share)) how.frames.push_back(frame);

  return how;
}

double CompositePattern::read_shape(int n, double y) const {
  if (n < steps()) return sinusoid_intensity({steps(), low}, n, y);
  return sine_cosine_mean_shape(n - steps(), high, y);
}

Layout CompositePattern::layout() const {
  const int frames = steps() + 3;
  Layout layout{.frames = frames,
                .bands = {sine_cosine_mean_band(frames, steps(), high)},
                .unwrapping = Unwrapping::surfaces};

  // The carriers' patterns are single frames of the low frequency.
  for (int n = 0; n < steps(); ++n) layout.single_frames.push_back({n, low, -2 * pi * n / steps()});

  return layout;
}

Demodulation read_as_fringes(int shown, double periods, SymbolGrid grid) {
  Demodulation how{.shown = shown, .frames = sine_cosine_mean(periods), .grid = std::move(grid)};
  for (const SpectralFrame& frame : sine_cosine_mean(1)) how.frames.push_back(frame);
  return how;
}

Layout fringes_of(const Demodulation& grid) {
  return {.frames = 6,
          .bands = {sine_cosine_mean_band(6, 0, grid.frames.front().periods),
                    sine_cosine_mean_band(6, 3, 1)},
          .unwrapping = Unwrapping::hierarchical};
}

}  // namespace slipstream
