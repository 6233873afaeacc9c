#include "frames/cycle_alignment.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "base/statistics.h"

namespace slipstream {
namespace {

/// A pixel shows patterns if its range over a cycle is at least this, grey levels of 255.
constexpr float least_range = 16;
/// Fewer samples are not conclusive.
constexpr int fewest_samples = 16;
/// Largest ratio of distances at which another index is preferred. Noise alone gives about equal
/// distances; a right and a wrong pattern differ by more.
constexpr float nearer = 0.5F;

/// Sum of squared deviations from each sample's mean over the cycle.
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

/// Sum of squared deviations from the common value of all runs, weighted by their frames.
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

/// Mean fraction of each sample's range by which each frame is darker (`sign` 1) or brighter (-1)
/// than all others, where the patterns show; negative if another frame is the extreme.
std::vector<double> extremity(const CycleSamples& cycle, double sign) {
  std::vector<double> sums(cycle.size());
  double used = 0;

  for (std::size_t i = 0; i < cycle.front().size(); ++i) {
    // The darkest and second darkest frame of this pixel, and the brightest.
    double first = std::numeric_limits<double>::infinity(), second = first, last = -first;
    for (const auto& frame : cycle) {
      const double I = sign * frame[i];
      second = std::min(second, std::max(first, I));
      first = std::min(first, I);
      last = std::max(last, I);
    }

    if (last - first < least_range) continue;
    ++used;

    // How far each frame is below all others.
    for (std::size_t index = 0; index < cycle.size(); ++index) {
      const double I = sign * cycle[index][i];
      sums[index] += ((I > first ? first : second) - I) / (last - first);
    }
  }

  for (double& sum : sums) sum = used < fewest_samples ? -1 : sum / used;

  return sums;
}

}  // namespace

std::vector<std::size_t> sample_places(Size size) {
  constexpr int most_pairs = 384;
  const int beside = std::max(1, size.width / 64);

  const auto place = [](double part, int length) {
    return std::min(static_cast<int>(part * length), length - 1);
  };

  std::vector<std::size_t> places;
  for (int i = 0; i < std::min(most_pairs, size.width * size.height / 2); ++i) {
    const auto [x, y] = spread_place(i);
    const int column = place(x, size.width), row = place(y, size.height);

    for (const int away : {0, beside}) {
      places.push_back(std::min(row + away, size.height - 1) * size.width +
                       std::min(column + away, size.width - 1));
    }
  }

  return places;
}

void sample(const Frame& frame, const std::vector<std::size_t>& places,
            std::vector<float>& samples) {
  samples.resize(places.size());
  const float scale = 255.0F / static_cast<float>((1 << frame.bits) - 1);

  std::visit(
      [&](const auto& image) {
        std::transform(places.begin(), places.end(), samples.begin(),
                       [&](std::size_t i) { return scale * static_cast<float>(image.begin()[i]); });
      },
      frame.pixels);
}

SlipWatch::SlipWatch(int cycle, std::size_t samples)
    : count_(cycle),
      last_(cycle, std::vector<float>(samples)),
      known_(cycle),
      distances_(cycle),
      suspects_(cycle, Seen{0, std::vector<float>(samples)}) {}

void SlipWatch::measure_distances(const std::vector<float>& samples) {
  std::fill(distances_.begin(), distances_.end(), 0.0F);

  int used = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    // Only samples where the patterns show.
    float least = samples[i], greatest = samples[i];
    for (const auto& frame : last_) {
      least = std::min(least, frame[i]);
      greatest = std::max(greatest, frame[i]);
    }

    if (greatest - least < least_range) continue;

    ++used;
    for (std::size_t index = 0; index < last_.size(); ++index) {
      distances_[index] += std::abs(samples[i] - last_[index][i]);
    }
  }

  if (used < fewest_samples || !has_cycle()) {
    std::fill(distances_.begin(), distances_.end(), std::numeric_limits<float>::infinity());
  }
}

void SlipWatch::keep(int index, const std::vector<float>& samples) {
  std::ranges::copy(samples, last_[index].begin());
  known_[index] = true;
}

void SlipWatch::settle(int places) {
  for (int i = 0; i < suspected_; ++i) {
    keep(moved(suspects_[i].index, places), suspects_[i].samples);
  }
  suspected_ = 0;
}

SlipWatch::Finding SlipWatch::look(int index, const std::vector<float>& samples) {
  measure_distances(samples);

  const float own = distances_[index];

  const auto nearest = std::min_element(distances_.begin(), distances_.end());
  const auto much_nearer = [](float a, float b) { return std::isfinite(b) && a <= nearer * b; };

  // 1. Another index, much nearer than its own: a suspicion, always of one and the same slip.
  const bool other = much_nearer(*nearest, own);
  const int places = moved(static_cast<int>(nearest - distances_.begin()), -index);
  if (other && (suspected_ == 0 || places != places_)) {
    settle(0);
    suspected_ = supporting_ = 0;
    places_ = places;
  }

  // 2. Suspicion ends with a frame that clearly agrees with its own index.
  const bool agrees = suspected_ == 0 && !other;
  if (agrees || much_nearer(own, distances_[moved(index, places_)])) {
    settle(0);
    keep(index, samples);
    return {};
  }

  // 3. Otherwise collect suspects, and judge once there is a full cycle of them.
  Seen& suspect = suspects_[suspected_++];
  suspect.index = index;
  std::ranges::copy(samples, suspect.samples.begin());
  if (other) ++supporting_;

  if (suspected_ == count_) {
    const bool slipped = 2 * supporting_ >= count_;
    settle(slipped ? places_ : 0);
    if (slipped) return {Verdict::slipped, places_};
    return {};
  }

  return {other ? Verdict::slipping : Verdict::agrees, 0};
}

void SlipWatch::move_on(int places) {
  const int first = moved(0, -places);
  std::rotate(last_.begin(), last_.begin() + first, last_.end());
  std::rotate(known_.begin(), known_.begin() + first, known_.end());
  suspected_ = 0;
}

CycleAlignment::CycleAlignment(std::vector<CycleRun> runs)
    : runs_(std::move(runs)), fits_(runs_.size()), turns_(runs_.size()) {}

/// For cyclic frame order, starting at `first`.
CycleAlignment::Fit CycleAlignment::fit(const CycleSamples& cycle, std::size_t sample, int first,
                                        const CycleRun& run) {
  Fit fit;

  double squares = 0;
  for (std::size_t n = 0; n < run.cosines.size(); ++n) {
    const double I = cycle[(first + run.first + n) % cycle.size()][sample];
    fit.mean += I;
    fit.cosine += run.cosines[n] * I;
    fit.sine += run.sines[n] * I;
    squares += I * I;
  }

  // The sum of squares less the parts of mean and sinusoid.
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

      // Noise makes the mean of N frames uncertain by 1 / N, the modulation by 2 / N.
      explanation.residual +=
          spread_over_runs(fits_, i, [](const Fit& of) { return of.mean; }) +
          spread_over_runs(fits_, i, [](const Fit& of) { return of.modulation(); }) / 2;
    }

    // How much each run's phase turns from a pixel to its neighbour.
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      const auto& [a, b] = fits_[r];  // adds B_1 B_2 (1 - cos(phi_1 - phi_2))
      turns_[r] += a.modulation() * b.modulation() - a.cosine * b.cosine - a.sine * b.sine;
    }
  }

  // More periods across the field turn the phase more.
  explanation.is_ordered = std::is_sorted(turns_.begin(), turns_.end(), std::less_equal<>());
  return explanation;
}

int CycleAlignment::misalignment(const CycleSamples& cycle) {
  if (runs_.empty()) return 0;

  /// Fraction of the cycle's variation: the frames of one scan leave less than this even with
  /// motion; wrongly grouped frames leave more.
  constexpr double little = 0.1;
  /// Variance of a sinusoid of 4 grey levels of 255; below it there is only noise.
  constexpr double least_variance = 8;

  const double all = variation(cycle);
  const auto values = static_cast<double>(cycle.size() * cycle.front().size());
  if (all < least_variance * values) return 0;

  // 1. The cycle as it is.
  const Explanation now = explain(cycle, 0);
  if (now.is_ordered && now.residual < little * all) return 0;

  // 2. From every other frame on.
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int first = 1; first < static_cast<int>(cycle.size()); ++first) {
    const Explanation explanation = explain(cycle, first);
    if (!explanation.is_ordered || explanation.residual >= least) continue;
    least = explanation.residual;
    best = first;
  }

  // 3. It must explain the cycle, and clearly better than before.
  const bool sure = least < little * all && (!now.is_ordered || 4 * least < now.residual);
  return best != 0 && sure ? static_cast<int>(cycle.size()) - best : 0;
}

std::optional<int> marker_misalignment(const CycleSamples& cycle) {
  /// At some pixels the darkest pattern is as dark as a dark marker, up to noise. Of two patterns,
  /// neither is darker everywhere.
  constexpr double as_dark = -0.05, apart = 0.1;

  std::optional<int> places;
  double clearest = apart;
  for (const double sign : {1.0, -1.0}) {
    // The most extreme frame, and its lead over the next one.
    std::vector<double> shares = extremity(cycle, sign);
    const auto marker = std::max_element(shares.begin(), shares.end());
    const auto index = static_cast<int>(marker - shares.begin());
    const double most = std::exchange(*marker, -std::numeric_limits<double>::infinity());
    const double lead = most - *std::max_element(shares.begin(), shares.end());

    if (most < as_dark || lead < clearest) continue;

    // The marker is the last of a cycle.
    clearest = lead;
    places = static_cast<int>(cycle.size()) - 1 - index;
  }

  return places;
}

}  // namespace slipstream
