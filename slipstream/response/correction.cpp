#include "slipstream/response/correction.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/decode/equations.h"
#include "slipstream/response/harmonics.h"

namespace slipstream {
namespace {

using std::numbers::pi;

/// The root of a rising function between two places, f(low) <= 0 <= f(high), to rounding: false
/// position, with the standing end's value halved (Illinois) and now and then the middle.
template <class Function>
double root_between(const Function& f, double low, double high) {
  constexpr double rounding = 4e-15;  // of f
  double f_low = f(low), f_high = f(high);
  if (f_low >= 0) return low;
  if (f_high <= 0) return high;
  bool moved_low = false, moved_high = false;
  for (int i = 1; i < 200 && high - low > 1e-15; ++i) {
    double place = low - f_low * (high - low) / (f_high - f_low);
    if (i % 8 == 0 || !(place > low && place < high)) place = std::midpoint(low, high);
    if (place == low || place == high) break;
    const double value = f(place);
    if (std::abs(value) < rounding) return place;
    if (value < 0) {
      low = place;
      f_low = value;
      if (std::exchange(moved_low, true)) f_high /= 2;
      moved_high = false;
    } else {
      high = place;
      f_high = value;
      if (std::exchange(moved_high, true)) f_low /= 2;
      moved_low = false;
    }
  }
  return std::midpoint(low, high);
}

void require_steps(int steps) {
  if (steps < 3) throw Error(fmt::format("{} steps are out of range; 3 or more", steps));
}

double added_at(const Response& response, int steps, double place) {
  const double measured = 2 * pi * place / steps;
  return true_phase(response, steps, measured) - measured;
}

}  // namespace

double true_phase(const Response& response, int steps, double measured) {
  return true_phase([&](double phi) { return distorted_phase(response, steps, phi); }, steps,
                    measured);
}

double true_phase(const std::function<double(double)>& distorted, int steps, double measured) {
  // Brings the measured phase to [0, pi / N], where measured and true phase agree at both ends and
  // rise together, and the solution back.
  const double half = pi / steps;
  const double period = std::floor(measured / half);
  const double within = measured - period * half;
  const bool mirrored = std::fmod(period, 2) != 0;
  const double target = mirrored ? half - within : within;
  const double phi = root_between([&](double trial) { return distorted(trial) - target; }, 0, half);
  return period * half + (mirrored ? half - phi : phi);
}

double noise_gain(const Response& response, int steps, double phi) {
  constexpr double step = 1e-4;
  return 2 * step /
         (distorted_phase(response, steps, phi + step) -
          distorted_phase(response, steps, phi - step));
}

PhaseCorrection phase_correction(const Response& response, int steps, double accuracy) {
  require_steps(steps);
  if (const auto* law = std::get_if<PowerLaw>(&response)) require_gamma(law->gamma, "gamma");
  constexpr std::size_t shortest = 256, longest = 65536;

  // The first half of the period; the second is the first in reverse with the other sign.
  std::vector<double> half;
  for (std::size_t i = 0; i <= shortest / 2; ++i) {
    half.push_back(added_at(response, steps, static_cast<double>(i) / shortest));
  }
  for (std::size_t length = shortest; length < longest; length *= 2) {
    double worst = 0;
    std::vector<double> denser{half.front()};
    for (std::size_t i = 0; i + 1 < half.size(); ++i) {
      const double between =
          added_at(response, steps, (static_cast<double>(i) + 0.5) / static_cast<double>(length));
      worst = std::max(worst, std::abs(between - std::midpoint(half[i], half[i + 1])));
      denser.insert(denser.end(), {between, half[i + 1]});
    }
    if (worst <= accuracy) break;
    half = std::move(denser);
  }
  PhaseCorrection correction{steps, half};
  for (std::size_t i = half.size() - 2; i > 0; --i) correction.added.push_back(-half[i]);
  return correction;
}

PhaseCorrections phase_corrections(const Response& response, std::span<const int> step_counts) {
  PhaseCorrections corrections;
  for (const int steps : step_counts) {
    if (!corrections.contains(steps)) corrections[steps] = phase_correction(response, steps);
  }
  return corrections;
}

PatternSet precompensated(const PatternSet& patterns, const Response& response) {
  PatternSet changed = patterns;
  changed.light = {.alpha_p = 255, .beta_p = 0};
  changed.shape = [patterns, response](int n, double y, double across) {
    return value_for(response, patterns.intensity(n, y, across) / 255);
  };
  return changed;
}

}  // namespace slipstream
