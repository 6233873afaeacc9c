#include "response/automatic_exposure.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "base/linear_algebra.h"
#include "base/throw_if-inl.h"
#include "slipstream/error.h"

namespace slipstream {
namespace {

constexpr double finer = 4, coarser = 8;  // factors between exposures that are tried

/// The scans taken so far, by exposure.
struct Tried {
  std::map<double, FrameSet> scans{};

  [[nodiscard]] double shortest() const { return scans.begin()->first; }
  [[nodiscard]] double longest() const { return scans.rbegin()->first; }

  /// nullopt if they show no pattern, or only saturated ones.
  [[nodiscard]] std::optional<ExposureAdvice> advice(const Sequence& sequence,
                                                     const ExposureNeeds& needs) const {
    Sequence taken = sequence;
    taken.exposures.clear();
    std::vector<FrameSet> sets;
    for (const auto& [exposure, frames] : scans) {
      taken.exposures.push_back(exposure);
      sets.push_back(frames);
    }

    try {
      return exposure_advice(joined(std::move(sets)), taken, needs);
    } catch (const Error&) {
      return std::nullopt;
    }
  }
};

/// Exposures from half a period of the light on become whole multiples of it, shorter ones whole
/// multiples of the refreshes.
double in_whole_periods(double exposure, const ExposureLimits& limits) {
  const double within = std::clamp(exposure, limits.shortest, limits.longest);

  for (const double period : {limits.flicker_period, limits.refresh_period}) {
    if (!(period > 0) || within < period / 2) continue;
    const double whole = std::max(1.0, std::round(within / period)) * period;
    if (whole <= limits.longest) return whole;
  }
  return within;
}

/// Whether the exposures of a proposal may be set.
bool is_within(const std::vector<double>& exposures, const ExposureLimits& limits) {
  constexpr double rounding = 1.01;
  const auto [shortest, longest] = std::ranges::minmax(exposures);
  return shortest * rounding >= limits.shortest && longest <= limits.longest * rounding &&
         std::accumulate(exposures.begin(), exposures.end(), 0.0) <= limits.total * rounding;
}

/// The proposal with the fewest exposures that measures nearly as much as any within the limits;
/// otherwise the first.
const ExposureChoice& chosen(const ExposureAdvice& advice, const ExposureLimits& limits) {
  constexpr double nearly = 0.005;  // of the lit pixels
  const ExposureChoice* best = &advice.proposed.front();
  for (std::size_t n = 1; n < std::min(advice.proposed.size(), limits.most); ++n) {
    const ExposureChoice& choice = advice.proposed[n];
    if (is_within(choice.exposures, limits) && choice.measured > best->measured + nearly) {
      best = &choice;
    }
  }
  return *best;
}

/// The exposure to try next; nullopt if enough is known. `without_gain`: number of longer
/// exposures, one after another, that have shown no more pixels.
std::optional<double> next_exposure(const Tried& tried, const std::optional<ExposureAdvice>& advice,
                                    const ExposureLimits& limits, int without_gain) {
  constexpr double few = 0.002;  // of the pixels
  constexpr int patience = 2;    // dark surfaces may begin to show at the second step
  const double shorter = std::max(tried.shortest() / finer, limits.shortest);
  const double longer = std::min(tried.longest() * finer, limits.longest);
  const bool can_shorten = shorter < tried.shortest();
  const bool can_lengthen = longer > tried.longest();

  // 1. No pattern is seen: towards less light if many pixels are saturated, else towards more. A
  // few are defects of the camera, or glints.
  if (!advice) {
    const Image<std::uint8_t> saturated = saturation_mask(tried.scans.begin()->second);
    const auto count = static_cast<double>(std::ranges::count(saturated, std::uint8_t{1}));
    if (count > few * static_cast<double>(saturated.pixel_count()) && can_shorten) {
      return std::max(tried.shortest() / coarser, limits.shortest);
    }
    if (!can_lengthen) return std::nullopt;
    return std::min(tried.longest() * coarser, limits.longest);
  }

  // 2. Pixels that every exposure saturates are not understood, nor those that none shows yet.
  if (advice->unknown > few && can_shorten) return shorter;
  if (without_gain < patience && can_lengthen) return longer;
  return std::nullopt;
}

/// Share of the variation of the levels that a sinusoid of that frequency explains, and its
/// amplitude in shares of the mean. A slow drift is left out.
std::pair<double, double> explained_by(double frequency, const std::vector<double>& times,
                                       const std::vector<double>& levels) {
  const auto count = static_cast<Eigen::Index>(times.size());
  Eigen::MatrixXd waves(count, 4);
  Eigen::VectorXd seen(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double time = times[static_cast<std::size_t>(i)] - times.front();
    const double angle = 2 * std::numbers::pi * frequency * time;
    waves.row(i) << 1, time, std::cos(angle), std::sin(angle);
    seen(i) = levels[static_cast<std::size_t>(i)];
  }

  const auto [fitted, rank] = least_squares(waves, seen);
  if (rank < 4) return {0, 0};  // sampled so that it looks constant

  const Eigen::MatrixXd drift = least_squares(waves.leftCols<2>(), seen).X;
  const double left = (seen - waves * fitted).squaredNorm();
  const double before = (seen - waves.leftCols<2>() * drift).squaredNorm();
  const double mean = std::max(seen.mean(), 1e-9);
  return {before > 0 ? 1 - left / before : 0, fitted.bottomRows<2>().norm() / mean};
}

}  // namespace

ChosenExposures choose_exposures(const std::function<FrameSet(double exposure)>& take,
                                 const Sequence& sequence, const ExposureLimits& limits,
                                 ExposureNeeds needs, const std::function<bool()>& goes_on) {
  needs.shortest = limits.shortest;
  needs.longest = limits.longest;
  constexpr std::size_t most_tried = 10;
  Tried tried;
  ChosenExposures result;
  std::optional<ExposureAdvice> advice;
  double lit = 0;
  int without_gain = 0;

  // 1. Scans with other exposures, until they say enough.
  double next = std::clamp(limits.first, limits.shortest, limits.longest);
  while (result.tried.size() < most_tried) {
    tried.scans.insert_or_assign(next, take(next));
    result.tried.push_back(next);
    advice = tried.advice(sequence, needs);

    constexpr double little = 0.002;  // of the pixels
    const double before = std::exchange(lit, advice ? advice->lit : 0);
    const bool is_longest = next == tried.longest();
    without_gain = is_longest && lit - before < little ? without_gain + 1 : 0;

    const auto further = next_exposure(tried, advice, limits, without_gain);
    if (!further || !goes_on()) break;
    next = *further;
  }
  throw_if(!advice,
           "no exposure from {:.3g} to {:.3g} shows the patterns; check that the projector lights "
           "the scene in view",
           tried.shortest(), tried.longest());

  // 2. The choice, in whole periods of the room's light.
  const ExposureChoice& best = chosen(*advice, limits);
  for (const double exposure : best.exposures) {
    result.exposures.push_back(in_whole_periods(exposure, limits));
  }
  result.exposures.erase(std::unique(result.exposures.begin(), result.exposures.end()),
                         result.exposures.end());
  result.lit = advice->lit;
  result.measured = best.measured;
  return result;
}

std::optional<double> flicker_period(const std::vector<double>& times,
                                     const std::vector<double>& levels) {
  constexpr std::size_t fewest = 16;
  constexpr double least_amplitude = 0.005, least_share = 0.6, alike = 0.05;
  if (times.size() != levels.size() || times.size() < fewest) return std::nullopt;

  // Light of mains flickers twice a period.
  const auto [share_50, amplitude_50] = explained_by(100, times, levels);
  const auto [share_60, amplitude_60] = explained_by(120, times, levels);
  const bool is_50 = share_50 > least_share && amplitude_50 > least_amplitude;
  const bool is_60 = share_60 > least_share && amplitude_60 > least_amplitude;
  if (!is_50 && !is_60) return std::nullopt;

  // Frames at some rates cannot tell them apart: 0.05 s are whole periods of both.
  if (is_50 && is_60 && std::abs(share_50 - share_60) < alike) return 0.05;
  return share_50 > share_60 ? 0.01 : 1.0 / 120;
}

}  // namespace slipstream
