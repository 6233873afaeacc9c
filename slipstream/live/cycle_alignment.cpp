#include "slipstream/live/cycle_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>

namespace slipstream {
namespace {

/// A sinusoid through N frames, Liu 2010, Eqs. (1.3)-(1.6).
struct Fit {
  double mean = 0, cosine = 0, sine = 0;  ///< A, B cos(phi), B sin(phi)
  double residual = 0;                    ///< sum of squares

  [[nodiscard]] double modulation() const { return std::hypot(cosine, sine); }
};

/// B_1 B_2 (1 - cos(phi_1 - phi_2)).
double turn_between(const Fit& a, const Fit& b) {
  return a.modulation() * b.modulation() - a.cosine * b.cosine - a.sine * b.sine;
}

/// Sum of squares about each sample's mean over the cycle.
double variation(const CycleSamples& cycle) {
  double sum = 0;
  for (std::size_t i = 0; i < cycle.front().size(); ++i) {
    double mean = 0, squares = 0;
    for (const auto& frame : cycle) {
      const double I = frame[i];
      mean += I;
      squares += I * I;
    }
    sum += squares - mean * mean / static_cast<double>(cycle.size());
  }
  return sum;
}

/// Of the frames from `first` on, all around.
Fit fit_sinusoid(const CycleSamples& cycle, std::size_t sample, int first,
                 const std::vector<double>& cosines, const std::vector<double>& sines) {
  Fit fit;
  double squares = 0;
  for (std::size_t n = 0; n < cosines.size(); ++n) {
    const double I = cycle[(static_cast<std::size_t>(first) + n) % cycle.size()][sample];
    fit.mean += I;
    fit.cosine += cosines[n] * I;
    fit.sine += sines[n] * I;
    squares += I * I;
  }
  const auto N = static_cast<double>(cosines.size());
  fit.mean /= N;
  fit.residual =
      squares - N * fit.mean * fit.mean - N / 2 * (fit.cosine * fit.cosine + fit.sine * fit.sine);
  return fit;
}

}  // namespace

struct CycleAlignment::Explanation {
  double residual = 0;             ///< sum of squares
  double high_turn = 0, turn = 0;  ///< how the first's and the second's phase varies

  [[nodiscard]] bool is_ordered() const { return high_turn > turn; }
};

CycleAlignment::CycleAlignment(const Strategy& strategy) : steps_(step_counts(strategy)) {
  for (const int N : steps_) {
    auto& cosines = cosines_.emplace_back();
    auto& sines = sines_.emplace_back();
    for (int n = 0; n < N; ++n) {
      cosines.push_back(2.0 / N * std::cos(2 * std::numbers::pi * n / N));
      sines.push_back(2.0 / N * std::sin(2 * std::numbers::pi * n / N));
    }
  }
}

CycleAlignment::Explanation CycleAlignment::explain(const CycleSamples& cycle, int first) const {
  const double N_h = steps_[0], N_l = steps_[1];
  const double weight = N_h * N_l / (N_h + N_l);
  Explanation explanation;
  std::array<Fit, 2> high, low;
  for (std::size_t sample = 0; sample + 1 < cycle.front().size(); sample += 2) {
    for (const std::size_t i : {0U, 1U}) {
      high[i] = fit_sinusoid(cycle, sample + i, first, cosines_[0], sines_[0]);
      low[i] = fit_sinusoid(cycle, sample + i, first + steps_[0], cosines_[1], sines_[1]);
      const double A = high[i].mean - low[i].mean;
      const double B = high[i].modulation() - low[i].modulation();
      // Noise of the frames makes the mean of N uncertain by 1 / N, the modulation by 2 / N.
      explanation.residual +=
          high[i].residual + low[i].residual + weight * A * A + weight / 2 * B * B;
    }
    explanation.high_turn += turn_between(high[0], high[1]);
    explanation.turn += turn_between(low[0], low[1]);
  }
  return explanation;
}

int CycleAlignment::misalignment(const CycleSamples& cycle) const {
  if (steps_.size() != 2) return 0;
  /// Shares of the cycle's variation: frames of one scan leave less than the first even where
  /// things move; wrongly grouped ones leave more.
  constexpr double little = 0.1;
  /// Variance of a sinusoid of 4 grey levels of 255: less of it is noise.
  constexpr double least_variance = 8;
  const double all = variation(cycle);
  const auto values = static_cast<double>(cycle.size() * cycle.front().size());
  if (all < least_variance * values) return 0;
  const Explanation now = explain(cycle, 0);
  if (now.is_ordered() && now.residual < little * all) return 0;

  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int first = 1; first < static_cast<int>(cycle.size()); ++first) {
    const Explanation explanation = explain(cycle, first);
    if (!explanation.is_ordered() || explanation.residual >= least) continue;
    least = explanation.residual;
    best = first;
  }
  const bool sure = least < little * all && (!now.is_ordered() || 4 * least < now.residual);
  return best != 0 && sure ? static_cast<int>(cycle.size()) - best : 0;
}

namespace {

/// How much of each sample's range the frames are darker (`sign` 1) or brighter (-1) than all
/// others, on average where the patterns show; negative where another one is.
std::vector<double> extremity(const CycleSamples& cycle, double sign) {
  constexpr double least_range = 16, fewest_samples = 16;
  std::vector<double> sums(cycle.size());
  double used = 0;
  for (std::size_t i = 0; i < cycle.front().size(); ++i) {
    double first = std::numeric_limits<double>::infinity(), second = first, last = -first;
    for (const auto& frame : cycle) {
      const double I = sign * frame[i];
      second = std::min(second, std::max(first, I));
      first = std::min(first, I);
      last = std::max(last, I);
    }
    if (last - first < least_range) continue;
    ++used;
    for (std::size_t index = 0; index < cycle.size(); ++index) {
      const double I = sign * cycle[index][i];
      sums[index] += ((I > first ? first : second) - I) / (last - first);
    }
  }
  for (double& sum : sums) sum = used < fewest_samples ? -1 : sum / used;
  return sums;
}

}  // namespace

std::optional<int> marker_misalignment(const CycleSamples& cycle) {
  /// Some pixels' darkest pattern is as dark as a dark marker, but for the noise; of two patterns
  /// one is darker here and the other there.
  constexpr double as_dark = -0.05, apart = 0.1;
  std::optional<int> places;
  double clearest = apart;
  for (const double sign : {1.0, -1.0}) {
    std::vector<double> shares = extremity(cycle, sign);
    const auto marker = std::max_element(shares.begin(), shares.end());
    const auto index = static_cast<int>(marker - shares.begin());
    const double most = std::exchange(*marker, -std::numeric_limits<double>::infinity());
    const double lead = most - *std::max_element(shares.begin(), shares.end());
    if (most < as_dark || lead < clearest) continue;
    clearest = lead;
    places = static_cast<int>(cycle.size()) - 1 - index;
  }
  return places;
}

}  // namespace slipstream
