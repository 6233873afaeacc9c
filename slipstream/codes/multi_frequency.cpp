#include "slipstream/codes/multi_frequency.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/sinusoid.h"
#include "slipstream/codes/unwrapping_chain.h"

namespace slipstream {
namespace {

constexpr std::array<std::pair<std::string_view, Unwrapping>, 3> ways{{
    {"hierarchical", Unwrapping::hierarchical},
    {"heterodyne", Unwrapping::beats},
    {"number-theory", Unwrapping::likelihood},
}};

/// The margin of the bands so unwrapped; 0 where they cannot be.
double margin_by(Layout layout, Unwrapping way) {
  layout.unwrapping = way;
  const bool begins = way == Unwrapping::hierarchical ? least_periods(layout) <= 1
                                                      : !unwrapping_chain(layout).empty();
  return begins ? unwrapping_margin(layout) : 0;
}

Unwrapping safest(const Layout& layout) {
  // A modulation of 40 grey levels, a noise of sigma_w^2 = 1.6.
  constexpr double enough = 6 * 1.26 / 40;
  Unwrapping best = Unwrapping::likelihood;
  double best_margin = 0;
  for (const auto& [name, way] : ways) {
    const double margin = margin_by(layout, way);
    if (margin >= enough) return way;
    if (margin > best_margin) std::tie(best, best_margin) = std::pair(way, margin);
  }
  return best;
}

}  // namespace

int MultiFrequency::step_count(std::size_t band) const {
  return steps.size() == 1 ? steps.front() : steps[band];
}

void MultiFrequency::require_valid() const {
  constexpr std::size_t most_bands = 8;
  if (periods.empty() || periods.size() > most_bands) {
    throw Error(
        fmt::format("multi-frequency: {} periods are given; 1 to {}", periods.size(), most_bands));
  }
  if (steps.size() != 1 && steps.size() != periods.size()) {
    throw Error(
        fmt::format("multi-frequency: {} steps for {} periods; one for all, or one for each",
                    steps.size(), periods.size()));
  }
  for (std::size_t i = 0; i < periods.size(); ++i) {
    slipstream::require_valid(Sinusoid{step_count(i), periods[i]}, "multi-frequency");
  }
  const bool known = std::any_of(ways.begin(), ways.end(),
                                 [&](const auto& way) { return way.first == unwrapping; });
  if (!unwrapping.empty() && !known) {
    throw Error(fmt::format(
        "multi-frequency: unwrapping '{}' is none of hierarchical, heterodyne, number-theory",
        unwrapping));
  }
}

double MultiFrequency::shape(int n, double y) const {
  std::size_t band = 0;
  while (n >= step_count(band)) n -= step_count(band++);
  return sinusoid_intensity({step_count(band), periods[band], shifts}, n, y);
}

Layout MultiFrequency::layout() const {
  Layout layout;
  for (std::size_t i = 0; i < periods.size(); ++i) layout.frames += step_count(i);
  for (std::size_t i = 0, first = 0; i < periods.size(); ++i) {
    layout.bands.push_back(phase_shifted_band(layout.frames, static_cast<int>(first), step_count(i),
                                              periods[i], 1, 1, shifts));
    first += static_cast<std::size_t>(step_count(i));
  }
  const auto way = std::find_if(ways.begin(), ways.end(),
                                [&](const auto& known) { return known.first == unwrapping; });
  layout.unwrapping = way != ways.end() ? way->second : safest(layout);
  return layout;
}

}  // namespace slipstream
