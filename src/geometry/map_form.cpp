#include "geometry/map_form.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/numbers.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

constexpr std::array<std::pair<MapUnit, std::string_view>, 4> named_units{{
    {MapUnit::coordinate, "coordinate"},
    {MapUnit::pixels, "pixels"},
    {MapUnit::phase, "phase"},
    {MapUnit::periods, "periods"},
}};

bool has_periods(MapUnit unit) {
  return unit == MapUnit::phase || unit == MapUnit::periods;
}

/// Share of the neighbours, right and below, whose phases differ by over half a period.
double share_of_jumps(const Image<double>& phase) {
  std::size_t pairs = 0, jumps = 0;
  const auto compare = [&](double one, double other) {
    if (!std::isfinite(one) || !std::isfinite(other)) return;
    ++pairs;
    if (std::abs(one - other) > two_pi / 2) ++jumps;
  };

  for (int row = 0; row + 1 < phase.height(); ++row) {
    for (int column = 0; column + 1 < phase.width(); ++column) {
      const double here = phase(column, row);
      compare(here, phase(column + 1, row));
      compare(here, phase(column, row + 1));
    }
  }

  return pairs == 0 ? 0 : static_cast<double>(jumps) / static_cast<double>(pairs);
}

/// Whether the values, rad, fill one turn from 0 or -pi, and jump from one end to the other.
bool is_wrapped(const Image<double>& phase, double least, double largest) {
  constexpr double nearly = 0.95, rounding = 1e-3;
  const bool in_turn = (least >= 0 && largest <= two_pi + rounding) ||
                       (least >= -two_pi / 2 - rounding && largest <= two_pi / 2 + rounding);
  if (!in_turn || largest - least <= nearly * two_pi) return false;

  // The phase of a single period jumps at most at the edges of surfaces.
  constexpr double fewest = 0.005;
  return share_of_jumps(phase) > fewest;
}

}  // namespace

MapForm map_form_named(const std::string& name) {
  std::string_view periods = name;
  const std::string_view word = take_until(periods, ':');

  for (const auto& [unit, unit_name] : named_units) {
    if (word != unit_name) continue;

    if (!has_periods(unit)) {
      if (word != name) break;
      return {.unit = unit};
    }

    const double count = number_in<double>(periods).value_or(0);
    if (!(count > 0 && std::isfinite(count))) break;
    return {.unit = unit, .periods = count};
  }

  throw Error(fmt::format("map '{}': expected {}", name, map_forms));
}

std::string name_of(const MapForm& form) {
  const std::string word(named_units.at(static_cast<std::size_t>(form.unit)).second);
  return has_periods(form.unit) ? fmt::format("{}:{:g}", word, form.periods) : word;
}

double span_of(const MapForm& form, int length) {
  switch (form.unit) {
    case MapUnit::coordinate:
      return 1;
    case MapUnit::pixels:
      return length;
    case MapUnit::phase:
      return two_pi * form.periods;
    case MapUnit::periods:
      return form.periods;
  }
  return 1;
}

double origin_of(const MapForm& form, int length) {
  if (form.origin) return *form.origin;
  if (!form.backwards) return 0;

  // Pixels are numbered: the last one is a pixel before the end.
  return form.unit == MapUnit::pixels ? length - 1 : span_of(form, length);
}

Image<double> coordinates_of_map(Image<double> map, const MapForm& form, int length) {
  const std::vector<double> values = finite_values(map);
  throw_if(values.empty(), "has no valid value");

  const auto [least, largest] = std::ranges::minmax_element(values);
  throw_if(form.unit == MapUnit::phase && form.periods > 1 && is_wrapped(map, *least, *largest),
           "the phase is wrapped, {:.4g} to {:.4g} rad; unwrap it, e.g. with `unwrap()`", *least,
           *largest);

  const double span = span_of(form, length), origin = origin_of(form, length);
  for (double& value : map) value = (form.backwards ? origin - value : value - origin) / span;
  return map;
}

}  // namespace slipstream
