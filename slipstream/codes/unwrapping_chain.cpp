#include "slipstream/codes/unwrapping_chain.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

namespace slipstream {
namespace {

using std::numbers::pi;
constexpr double infinity = std::numeric_limits<double>::infinity();

PhaseSum band_alone(const Layout& layout, std::size_t band) {
  PhaseSum sum{.of = std::vector<int>(layout.bands.size()), .periods = layout.bands[band].periods};
  sum.of[band] = 1;
  return sum;
}

/// Variance of the band's phase where a share of 1 has a modulation of B = 1, frames one of 1.
double phase_noise(const Band& band) {
  return component_noise(band) / (band.share * band.share);
}

/// How far noise must carry C + i S to turn it by `angle`, in standard deviations, squared.
double turn(double angle, double phase_noise) {
  const double distance = std::sin(std::min(std::abs(angle), pi / 2));
  return distance * distance / phase_noise;
}

/// Standard deviations from the right fringe order of `fine`, given `coarse`, to the next one.
double margin(const Layout& layout, const PhaseSum& coarse, const PhaseSum& fine) {
  const double ratio = fine.periods / coarse.periods;
  const auto factor = [&](std::size_t i) { return ratio * coarse.of[i] - fine.of[i]; };
  double variance = 0;
  for (std::size_t i = 0; i < layout.bands.size(); ++i) {
    variance += factor(i) * factor(i) * phase_noise(layout.bands[i]);
  }
  double square = 0;
  for (std::size_t i = 0; i < layout.bands.size(); ++i) {
    const double noise = phase_noise(layout.bands[i]);
    square += turn(pi * factor(i) * noise / variance, noise);
  }
  return std::sqrt(square);
}

/// All sums of factors from -2 to 2, at most four bands counted, from few periods to many up to
/// those of the measuring band, which is the last.
std::vector<PhaseSum> beats(const Layout& layout) {
  constexpr int most_factor = 2, most_bands = 4;
  constexpr double least_periods = 0.02;
  const PhaseSum measuring = band_alone(layout, measuring_band_index(layout));
  std::vector<PhaseSum> sums{{std::vector<int>(layout.bands.size()), 0}};
  for (std::size_t i = 0; i < layout.bands.size(); ++i) {
    const std::vector<PhaseSum> before = sums;
    for (int factor = -most_factor; factor <= most_factor; ++factor) {
      if (factor == 0) continue;
      for (PhaseSum sum : before) {
        sum.of[i] = factor;
        sum.periods += factor * layout.bands[i].periods;
        int counted = 0;
        for (const int of : sum.of) counted += std::abs(of);
        if (counted <= most_bands) sums.push_back(std::move(sum));
      }
    }
  }
  std::erase_if(sums, [&](const PhaseSum& sum) {
    return sum.periods < least_periods || sum.periods >= measuring.periods;
  });
  std::stable_sort(sums.begin(), sums.end(),
                   [](const PhaseSum& a, const PhaseSum& b) { return a.periods < b.periods; });
  sums.push_back(measuring);
  return sums;
}

constexpr double chain_rounding = 1e-9;

bool is_whole(double ratio) {
  return std::abs(ratio - std::round(ratio)) <= chain_rounding;
}

/// Of all chains from at most one period to the measuring band that whose worst step is surest;
/// empty where there is none. `circle_of`: of sums alone that repeat as that one does.
std::vector<PhaseSum> surest_chain(const Layout& layout, std::vector<PhaseSum> sums,
                                   std::optional<double> circle_of) {
  const auto repeats = [&](const PhaseSum& sum) {
    return !circle_of || is_whole(sum.periods / *circle_of);
  };
  if (!repeats(sums.back())) return {};
  std::erase_if(sums, [&](const PhaseSum& sum) { return !repeats(sum); });
  struct Way {
    double surest = 0;
    std::size_t from = 0;
    int steps = 0;
  };
  std::vector<Way> ways(sums.size());
  for (std::size_t fine = 0; fine < sums.size(); ++fine) {
    const bool begins = circle_of ? sums[fine].periods <= *circle_of + chain_rounding
                                  : sums[fine].periods <= 1 + chain_rounding;
    if (begins) ways[fine] = {infinity, fine, 0};
    for (std::size_t coarse = 0; coarse < fine; ++coarse) {
      if (ways[coarse].surest == 0 || ways[fine].surest == infinity) continue;
      const double surest = std::min(ways[coarse].surest, margin(layout, sums[coarse], sums[fine]));
      const Way way{surest, coarse, ways[coarse].steps + 1};
      const bool shorter =
          way.surest > ways[fine].surest - chain_rounding && way.steps < ways[fine].steps;
      if (way.surest > ways[fine].surest + chain_rounding || shorter) ways[fine] = way;
    }
  }
  std::vector<PhaseSum> chain;
  if (ways.back().surest == 0) return chain;
  std::size_t at = sums.size() - 1;
  for (; ways[at].from != at; at = ways[at].from) chain.insert(chain.begin(), sums[at]);
  chain.insert(chain.begin(), sums[at]);
  return chain;
}

std::vector<WrongOrder> wrong_steps(const Layout& layout, const std::vector<PhaseSum>& chain) {
  std::vector<WrongOrder> wrong;
  for (std::size_t i = 1; i < chain.size(); ++i) {
    wrong.push_back({margin(layout, chain[i - 1], chain[i]), 2});
  }
  return wrong;
}

double nearest_of(const std::vector<WrongOrder>& wrong) {
  double nearest = infinity;
  for (const WrongOrder& order : wrong) nearest = std::min(nearest, order.margin);
  return nearest;
}

double worst_step(const Layout& layout, const std::vector<PhaseSum>& chain) {
  return nearest_of(wrong_steps(layout, chain));
}

/// One that is a circle does not mind the field's ends; it may be somewhat less sure for that.
std::vector<PhaseSum> chain_of_beats(const Layout& layout) {
  constexpr double worth = 0.7;
  const std::vector<PhaseSum> sums = beats(layout);
  std::vector<PhaseSum> any = surest_chain(layout, sums, std::nullopt), circle;
  for (const PhaseSum& first : sums) {
    if (first.periods > 1 + chain_rounding) break;
    std::vector<PhaseSum> chain = surest_chain(layout, sums, first.periods);
    if (chain.empty()) continue;
    const double sure = worst_step(layout, chain);
    if (circle.empty() || sure > worst_step(layout, circle) + chain_rounding)
      circle = std::move(chain);
  }
  const bool good =
      !circle.empty() && worst_step(layout, circle) >= worth * worst_step(layout, any);
  return good ? circle : any;
}

/// The coordinates at which the measuring band has the same phase: half way to what fits all bands
/// best there.
std::vector<WrongOrder> wrong_likelihoods(const Layout& layout) {
  const double f_h = measuring_band(layout).periods;
  std::vector<WrongOrder> wrong;
  for (int k = 1; k < f_h; ++k) {
    const auto apart = [&](const Band& band) {
      const double turns = band.periods * k / f_h;
      return 2 * pi * (turns - std::round(turns));
    };
    double along = 0, length = 0, square = 0;
    for (const Band& band : layout.bands) {
      along += apart(band) * band.periods / phase_noise(band);
      length += band.periods * band.periods / phase_noise(band);
    }
    for (const Band& band : layout.bands) {
      square += turn((apart(band) - along / length * band.periods) / 2, phase_noise(band));
    }
    wrong.push_back({std::sqrt(square), 2 * (f_h - k) / f_h});
  }
  return wrong;
}

}  // namespace

std::vector<PhaseSum> unwrapping_chain(const Layout& layout) {
  if (layout.unwrapping == Unwrapping::beats) return chain_of_beats(layout);
  std::vector<PhaseSum> chain;
  if (layout.unwrapping == Unwrapping::hierarchical) {
    for (const std::size_t i : coarse_to_fine(layout)) chain.push_back(band_alone(layout, i));
  } else {
    chain.push_back(band_alone(layout, measuring_band_index(layout)));
  }
  return chain;
}

bool is_circle(const Layout& layout) {
  const std::vector<PhaseSum> chain = unwrapping_chain(layout);
  return std::all_of(chain.begin(), chain.end(), [&](const PhaseSum& sum) {
    return is_whole(sum.periods / chain.front().periods);
  });
}

std::vector<double> band_weights(const Layout& layout) {
  std::vector<double> weights(layout.bands.size());
  const bool weighs =
      layout.unwrapping == Unwrapping::beats || layout.unwrapping == Unwrapping::likelihood;
  const std::size_t measuring = measuring_band_index(layout);
  weights[measuring] = 1;
  if (!weighs) return weights;
  const auto precision = [](const Band& band) {
    return band.periods * band.periods / phase_noise(band);
  };
  const double best = precision(layout.bands[measuring]);
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double share = precision(layout.bands[i]) / best;
    weights[i] = share < 0.01 ? 0 : share;
    sum += weights[i];
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

double least_periods(const Layout& layout) {
  switch (layout.unwrapping) {
    case Unwrapping::none:
    case Unwrapping::hierarchical:
      return layout.bands[coarse_to_fine(layout).front()].periods;
    case Unwrapping::beats:
      return unwrapping_chain(layout).front().periods;
    default:
      return 1;
  }
}

double open_by_code(const Code& code, double periods) {
  return std::min(periods / (2 * code.stripes), 0.4);
}

std::vector<WrongOrder> wrong_orders(const Layout& layout) {
  if (layout.unwrapping == Unwrapping::likelihood) return wrong_likelihoods(layout);
  return wrong_steps(layout, unwrapping_chain(layout));
}

double unwrapping_margin(const Layout& layout) {
  return nearest_of(wrong_orders(layout));
}

}  // namespace slipstream
