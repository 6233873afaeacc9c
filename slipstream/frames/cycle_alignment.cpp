#include "slipstream/frames/cycle_alignment.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <utility>

namespace slipstream {
namespace {

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

/// Sum of squares about what all runs have in common, each frame counted.
template <class Fits, class Value>
double spread_over_runs(const Fits& fits, std::size_t sample, const Value& value) {
  double frames = 0, sum = 0, squares = 0;
  for (const auto& fit : fits) {
    const double N = fit[sample].frames, v = value(fit[sample]);
    frames += N;
    sum += N * v;
    squares += N * v * v;
  }
  return squares - sum * sum / frames;
}

/// B_1 B_2 (1 - cos(phi_1 - phi_2)).
template <class Fit>
double turn_between(const Fit& a, const Fit& b) {
  return a.modulation() * b.modulation() - a.cosine * b.cosine - a.sine * b.sine;
}

}  // namespace

double CycleAlignment::Fit::modulation() const {
  return std::sqrt(cosine * cosine + sine * sine);
}

struct CycleAlignment::Explanation {
  double residual = 0;      ///< sum of squares
  bool is_ordered = false;  ///< the phases of more periods vary more
};

CycleAlignment::CycleAlignment(const Layout& layout) {
  int covered = 0;
  for (const std::size_t i : coarse_to_fine(layout)) {
    const auto run = step_run(layout.bands[i]);
    if (!run) break;
    covered += run->steps;
    runs_.push_back({run->first, channel_cosines(run->steps, 1), channel_sines(run->steps, 1)});
  }
  if (runs_.size() < 2 || covered != layout.frames) runs_.clear();
  fits_.resize(runs_.size());
  turns_.resize(runs_.size());
}

/// Of the frames from `first` on, all around.
CycleAlignment::Fit CycleAlignment::fit(const CycleSamples& cycle, std::size_t sample, int first,
                                        const Run& run) {
  Fit fit;
  double squares = 0;
  for (std::size_t n = 0; n < run.cosines.size(); ++n) {
    const double I =
        cycle[(static_cast<std::size_t>(first + run.first) + n) % cycle.size()][sample];
    fit.mean += I;
    fit.cosine += run.cosines[n] * I;
    fit.sine += run.sines[n] * I;
    squares += I * I;
  }
  const auto N = static_cast<double>(run.cosines.size());
  fit.frames = N;
  fit.mean /= N;
  fit.residual =
      squares - N * fit.mean * fit.mean - N / 2 * (fit.cosine * fit.cosine + fit.sine * fit.sine);
  return fit;
}

CycleAlignment::Explanation CycleAlignment::explain(const CycleSamples& cycle, int first) {
  Explanation explanation;
  std::fill(turns_.begin(), turns_.end(), 0.0);
  for (std::size_t sample = 0; sample + 1 < cycle.front().size(); sample += 2) {
    for (const std::size_t i : {0U, 1U}) {
      for (std::size_t r = 0; r < runs_.size(); ++r) {
        fits_[r][i] = fit(cycle, sample + i, first, runs_[r]);
        explanation.residual += fits_[r][i].residual;
      }
      // Noise of the frames makes the mean of N uncertain by 1 / N, the modulation by 2 / N.
      explanation.residual +=
          spread_over_runs(fits_, i, [](const Fit& of) { return of.mean; }) +
          spread_over_runs(fits_, i, [](const Fit& of) { return of.modulation(); }) / 2;
    }
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      turns_[r] += turn_between(fits_[r][0], fits_[r][1]);
    }
  }
  explanation.is_ordered = std::is_sorted(turns_.begin(), turns_.end(), std::less_equal<>());
  return explanation;
}

int CycleAlignment::misalignment(const CycleSamples& cycle) {
  if (runs_.empty()) return 0;
  /// Shares of the cycle's variation: frames of one scan leave less than the first even where
  /// things move; wrongly grouped ones leave more.
  constexpr double little = 0.1;
  /// Variance of a sinusoid of 4 grey levels of 255: less of it is noise.
  constexpr double least_variance = 8;
  const double all = variation(cycle);
  const auto values = static_cast<double>(cycle.size() * cycle.front().size());
  if (all < least_variance * values) return 0;
  const Explanation now = explain(cycle, 0);
  if (now.is_ordered && now.residual < little * all) return 0;

  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int first = 1; first < static_cast<int>(cycle.size()); ++first) {
    const Explanation explanation = explain(cycle, first);
    if (!explanation.is_ordered || explanation.residual >= least) continue;
    least = explanation.residual;
    best = first;
  }
  const bool sure = least < little * all && (!now.is_ordered || 4 * least < now.residual);
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
