#include "codes/phase_chain.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

namespace slipstream {
namespace {

using std::numbers::pi;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Standard deviations from the right fringe order of `fine`, given `coarse`, to the next one.
double margin(const Layout& layout, const PhaseSum& coarse, const PhaseSum& fine) {
  const double ratio = fine.periods / coarse.periods;
  const auto factor = [&](std::size_t i) { return ratio * coarse.of[i] - fine.of[i]; };

  // Variance of the fine phase minus its prediction from the coarse one.
  double variance = 0;
  for (std::size_t i = 0; i < layout.bands.size(); ++i) {
    variance += factor(i) * factor(i) * phase_noise(layout.bands[i]);
  }

  // The likeliest noise that turns this difference by pi: each band's part of it, in deviations.
  double square = 0;
  for (std::size_t i = 0; i < layout.bands.size(); ++i) {
    const double noise = phase_noise(layout.bands[i]);
    square += turn(pi * factor(i) * noise / variance, noise);
  }

  return std::sqrt(square);
}

/// All sums with factors from -2 to 2 and at most four bands counted, from fewest periods up to the
/// measuring band, which is last.
std::vector<PhaseSum> beats(const Layout& layout) {
  constexpr int most_factor = 2, most_bands = 4;
  constexpr double least_periods = 0.02;
  const PhaseSum measuring = band_alone(layout, measuring_band_index(layout));
  std::vector<PhaseSum> sums{{std::vector<int>(layout.bands.size()), 0}};

  // Add the bands one after another, with every factor.
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

  // A sum of hardly any periods gives no position; one as fine as the measuring band is not needed.
  std::erase_if(sums, [&](const PhaseSum& sum) {
    return sum.periods < least_periods || sum.periods >= measuring.periods;
  });

  std::ranges::stable_sort(sums, {}, &PhaseSum::periods);
  sums.push_back(measuring);
  return sums;
}

/// The chain from at most one period to the measuring band whose worst step has the largest margin;
/// an empty one if impossible. `circle_of`: uses only sums that repeat with these periods.
std::vector<PhaseSum> surest_chain(const Layout& layout, std::vector<PhaseSum> sums,
                                   std::optional<double> circle_of) {
  const auto repeats = [&](const PhaseSum& sum) {
    return !circle_of || is_whole(sum.periods / *circle_of);
  };
  if (!repeats(sums.back())) return {};
  std::erase_if(sums, [&](const PhaseSum& sum) { return !repeats(sum); });

  // The best way to each sum: its worst margin, the sum before it and the number of steps.
  struct Way {
    double surest = 0;
    std::size_t from = 0;
    int steps = 0;
  };
  std::vector<Way> ways(sums.size());

  // Sums of at most one period start a chain.
  for (std::size_t fine = 0; fine < sums.size(); ++fine) {
    if (sums[fine].periods <= circle_of.value_or(1) + chain_rounding) {
      ways[fine] = {infinity, fine, 0};
    }

    // All others continue the chain of a coarser sum: the one with the best margin or, at equal
    // margins, the shortest.
    for (std::size_t coarse = 0; coarse < fine; ++coarse) {
      if (ways[coarse].surest == 0 || ways[fine].surest == infinity) continue;
      const double surest = std::min(ways[coarse].surest, margin(layout, sums[coarse], sums[fine]));
      const Way way{surest, coarse, ways[coarse].steps + 1};

      const bool shorter =
          way.surest > ways[fine].surest - chain_rounding && way.steps < ways[fine].steps;
      if (way.surest > ways[fine].surest + chain_rounding || shorter) ways[fine] = way;
    }
  }

  // Follow the best way back from the measuring band.
  if (ways.back().surest == 0) return {};
  std::size_t at = sums.size() - 1;
  std::vector<PhaseSum> chain{sums[at]};
  for (; ways[at].from != at; at = ways[at].from) chain.insert(chain.begin(), sums[ways[at].from]);

  return chain;
}

}  // namespace

bool is_whole(double ratio) {
  return std::abs(ratio - std::round(ratio)) <= chain_rounding;
}

PhaseSum band_alone(const Layout& layout, std::size_t band) {
  PhaseSum sum{.of = std::vector<int>(layout.bands.size()), .periods = layout.bands[band].periods};
  sum.of[band] = 1;
  return sum;
}

double phase_noise(const Band& band) {
  return component_noise(band) / (band.share * band.share);
}

double turn(double angle, double phase_noise) {
  const double distance = std::sin(std::min(std::abs(angle), pi / 2));
  return distance * distance / phase_noise;
}

std::vector<PhaseSum> chain_of_bands(const Layout& layout) {
  std::vector<PhaseSum> chain;
  for (const std::size_t i : coarse_to_fine(layout)) chain.push_back(band_alone(layout, i));
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

std::vector<PhaseSum> chain_of_beats(const Layout& layout) {
  constexpr double worth = 0.7;
  const auto surest_of = [&](const std::vector<PhaseSum>& chain) {
    return nearest_of(wrong_steps(layout, chain));
  };

  // The best chain of any kind, and the best one that is cyclic with its first sum's periods.
  const std::vector<PhaseSum> sums = beats(layout);
  std::vector<PhaseSum> any = surest_chain(layout, sums, std::nullopt), circle;

  for (const PhaseSum& first : sums) {
    if (first.periods > 1 + chain_rounding) break;
    std::vector<PhaseSum> chain = surest_chain(layout, sums, first.periods);
    if (chain.empty()) continue;
    if (circle.empty() || surest_of(chain) > surest_of(circle) + chain_rounding)
      circle = std::move(chain);
  }

  return !circle.empty() && surest_of(circle) >= worth * surest_of(any) ? circle : any;
}

}  // namespace slipstream
