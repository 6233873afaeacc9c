#include "response/gamma_calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "response/harmonics.h"
#include "response/response_fit.h"
#include "response/scan_average.h"

namespace slipstream {
namespace {

using Complex = std::complex<double>;

using Samples = std::vector<HarmonicSample>;

/// The gamma on which the pixels' medians agree, within 1 %.
double agreed_gamma(const Samples& samples, int steps) {
  const ConstraintCurve curve = constraint_curve(samples, PowerLaw{1}, steps);

  double best_gamma = 1, best = std::numeric_limits<double>::infinity();
  for (double gamma = least_gamma; gamma <= largest_gamma; gamma *= 1.02) {
    const double left = distance(curve, PowerLaw{gamma});
    if (left < best) {
      best = left;
      best_gamma = gamma;
    }
  }

  return best_gamma;
}

struct Fit {
  double gamma = 1;
  double standard_error = 0;
  double offset = 0;  ///< light that no gamma explains, grey levels
};

enum class Offset { none, free };

/// Least squares with Tukey's weights, from a gamma near the solution. With a free offset the mean
/// of every pixel may include a common light besides the pattern's (N = 3).
Fit fitted(const Samples& samples, int steps, double gamma, Offset offset) {
  Fit fit{.gamma = gamma};
  for (int round = 0; round < 60; ++round) {
    const double h = 1e-3 * fit.gamma;
    const auto model = predicted(samples, PowerLaw{fit.gamma}, steps);
    const auto below = predicted(samples, PowerLaw{fit.gamma - h}, steps);
    const auto above = predicted(samples, PowerLaw{fit.gamma + h}, steps);
    // In grey levels: residual r, its derivatives J for gamma and 1 for the offset.
    const auto residual = [&](std::size_t i) {
      return (samples[i].constraint.second - model[i].second) * samples[i].modulation -
             (offset == Offset::free ? fit.offset : 0);
    };
    const auto slope = [&](std::size_t i) {
      return (above[i].second - below[i].second) * (samples[i].modulation / (2 * h));
    };

    // 1. Robust scale of the residuals, for Tukey's weights.
    std::vector<double> sizes;
    sizes.reserve(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) sizes.push_back(std::abs(residual(i)));
    const double scale = std::max(deviation_from_median(median(sizes)), 1e-10);

    // 2. Weighted normal equations of gamma and, if free, the offset, solved by Cramer's rule.
    double JJ = 0, J1 = 0, weights = 0, Jr = 0, r1 = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double weight = tukey_weight(sizes[i] / scale);
      const Complex J = slope(i), r = residual(i);
      JJ += weight * std::norm(J);
      J1 += weight * J.real();
      weights += weight;
      Jr += weight * (std::conj(J) * r).real();
      r1 += weight * r.real();
    }

    const double free = offset == Offset::free ? 1 : 0;
    const double determinant = JJ * weights - free * J1 * J1;
    const double step = (Jr * weights - free * J1 * r1) / determinant;
    fit.offset += free * (JJ * r1 - J1 * Jr) / determinant;

    // 3. Sandwich estimate of gamma's standard error: the scatter of each pixel's own contribution.
    double scatter = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double weight = tukey_weight(sizes[i] / scale);
      const Complex along = std::conj(slope(i) * weights - free * J1) * residual(i);
      scatter += weight * weight * along.real() * along.real();
    }
    fit.standard_error = std::sqrt(scatter) / determinant;

    // Steps of at most 10 % keep the linearisation valid.
    const double limited = std::clamp(step, -0.1 * fit.gamma, 0.1 * fit.gamma);
    fit.gamma = std::clamp(fit.gamma + limited, least_gamma / 2, 2 * largest_gamma);
    if (std::abs(step) < 1e-9) break;
  }

  return fit;
}

/// Whether the residual of the power law is no more than noise, or a small part of its effect. With
/// fewer steps, other responses are harder to distinguish: four detect odd harmonics, which distort
/// their phase, in the mean alone, and three have only the mean.
bool follows_power_law(const Samples& samples, double gamma, int steps) {
  if (!(gamma >= least_gamma && gamma <= largest_gamma)) return false;
  const Response law = PowerLaw{gamma}, linear = PowerLaw{1};
  const ConstraintCurve curve = constraint_curve(samples, law, steps);

  // A misfit of the mean below a tenth of one pixel's noise is hidden by it.
  const double of_mean = misfit_of_mean(curve, law), drowned = 0.1 * curve.noise;
  if (steps == 3) return of_mean <= std::max(0.002, drowned);

  // The share of the error without correction that may remain.
  const double share = steps == 4 ? 0.01 : 0.05;
  if (misfit(curve, law) > std::max(harmless_misfit(curve), share * misfit(curve, linear))) {
    return false;
  }

  return steps > 4 || of_mean <= std::max({0.001, drowned, 0.2 * misfit_of_mean(curve, linear)});
}

/// Whether gamma is unaffected by possible light other than the pattern's.
bool survives_ambient_light(const Samples& samples, const Fit& fit, double tolerance) {
  const Fit with_offset = fitted(samples, 3, fit.gamma, Offset::free);
  return std::abs(with_offset.gamma - fit.gamma) <= tolerance &&
         3 * with_offset.standard_error <= tolerance;
}

bool is_power_law(const BlindGamma& fit) {
  return fit.accepted() || fit.refusal == BlindRefusal::no_distortion;
}

PixelGamma gamma_of_pixels(const Image<MeasuredHarmonics>& pixels, const Image<std::uint8_t>& lit) {
  PixelGamma found{.map = gamma_map(pixels, lit)};
  found.estimate = robust_gamma(found.map);

  const double reach = std::max(5 * found.estimate.spread, 1e-3);
  found.histogram =
      histogram(found.map, found.estimate.gamma - reach, found.estimate.gamma + reach, 50);
  return found;
}

/// The sinusoid's values as seen by the lit pixels: mean over all of them and all frames,
/// normalised by each pixel's mean and modulation. nullopt if no pixel saw black or white.
std::optional<ResponseCurve> curve_seen(const FrameViews& frames,
                                        const Image<MeasuredHarmonics>& pixels,
                                        const Image<std::uint8_t>& lit, const StepRun& run) {
  constexpr int pieces = 64;  // of half a period
  constexpr double pi = std::numbers::pi;

  std::vector<double> sum(pieces + 1), count(pieces + 1), values, levels;
  for (int n = 0; n < run.steps; ++n) {
    // One frame as numbers, whatever its pixel type.
    std::vector<double> only(frames.count());
    only[run.first + n] = 1;
    const Image<double> level = weighted_sum(frames, only);

    for (std::size_t i = 0; i < lit.pixel_count(); ++i) {
      if (lit.begin()[i] == 0) continue;
      const MeasuredHarmonics& pixel = pixels.begin()[i];

      // The pattern's phase in this frame, folded to half a period: the cosine is symmetric.
      const double angle = std::arg(pixel.fundamental) - 2 * pi * n / run.steps;
      const double folded = std::abs(std::remainder(angle, 2 * pi));
      const auto piece = static_cast<std::size_t>(std::lround(folded / pi * pieces));
      sum[piece] += (level.begin()[i] - pixel.mean) / std::abs(pixel.fundamental);
      ++count[piece];
    }
  }

  if (count.front() == 0 || count.back() == 0) return std::nullopt;

  // Dark to bright: the cosine falls from 1 to -1 with the angle. Values that no pixel saw
  // are left out.
  for (int i = pieces; i >= 0; --i) {
    if (count[i] == 0) continue;
    values.push_back(i == pieces ? 0 : 0.5 + 0.5 * std::cos(pi * i / pieces));
    levels.push_back(sum[i] / count[i]);
  }

  return response_curve(values, levels);
}

/// Adds misfit and response.
void add_response(GammaCalibration& found, const Image<MeasuredHarmonics>& pixels,
                  const Image<std::uint8_t>& lit, const FrameViews& frames, const StepRun& run) {
  constexpr int fewest_for_curve = 8;
  // With fewer steps, the harmonics that distort the phases also blur the curve.
  constexpr int fewest_for_seen = 12;
  constexpr double most_left = 0.05;  // of the misfit without correction

  const Response law = PowerLaw{std::clamp(found.fit.gamma, least_gamma, largest_gamma)};
  const ConstraintCurve curve =
      constraint_curve(harmonic_samples(pixels, lit, found.steps), law, found.steps);
  const auto serves = [&](const Response& response) {
    return misfit(curve, response) <= harmless_misfit(curve);
  };

  found.misfit = misfit(curve, law);
  if (is_power_law(found.fit) && serves(law)) {
    found.response = NamedResponse{"power law", law};
  } else if (found.steps >= fewest_for_curve) {
    found.response = curve_that_serves(
        [&](const Response& response) { return distance(curve, response); }, serves);
  }

  if (!found.response && found.steps >= fewest_for_seen) {
    const auto seen = curve_seen(frames, pixels, lit, run);
    if (seen && misfit(curve, *seen) < most_left * misfit(curve, PowerLaw{1})) {
      found.response = NamedResponse{"measured curve", *seen};
    }
  }
}

}  // namespace

BlindGamma find_gamma(const Image<MeasuredHarmonics>& pixels, const Image<std::uint8_t>& lit,
                      int steps) {
  constexpr std::size_t fewest_pixels = 100;
  constexpr double ambient_tolerance = 0.03, negligible = 1e-3;

  const Samples samples = harmonic_samples(pixels, lit, steps);
  BlindGamma found{.pixels = samples.size()};

  if (samples.size() < fewest_pixels) {
    found.refusal = BlindRefusal::too_few_pixels;
    return found;
  }

  const Fit fit = fitted(samples, steps, agreed_gamma(samples, steps), Offset::none);

  // Noise may push gamma a little out of the modelled range.
  const double inside = std::clamp(fit.gamma, least_gamma, largest_gamma);
  const bool within_noise = std::abs(inside - fit.gamma) <= 0.01 * fit.gamma;
  found.gamma = within_noise ? inside : fit.gamma;
  found.standard_error = fit.standard_error;

  if (steps == 3 && !survives_ambient_light(samples, fit, ambient_tolerance * fit.gamma)) {
    found.refusal = BlindRefusal::ambient_light;
  } else if (!follows_power_law(samples, found.gamma, steps)) {
    found.refusal = BlindRefusal::no_power_law;
  } else if (std::abs(fit.gamma - 1) <= std::max(3 * fit.standard_error, negligible)) {
    found.refusal = BlindRefusal::no_distortion;
  }

  return found;
}

BlindGamma find_gamma(const FrameViews& frames, int first, int steps) {
  const Image<MeasuredHarmonics> pixels = pixel_harmonics(frames, first, steps);
  return find_gamma(pixels, well_lit(pixels, frames), steps);
}

double gamma_from_harmonics(double B_1, double B_2) {
  return (B_1 + 2 * B_2) / (B_1 - B_2);
}

Image<double> gamma_map(const Image<MeasuredHarmonics>& pixels, const Image<std::uint8_t>& lit) {
  Image<double> map(pixels.size(), std::numeric_limits<double>::quiet_NaN());

  for (std::size_t i = 0; i < pixels.pixel_count(); ++i) {
    const MeasuredHarmonics& pixel = pixels.begin()[i];
    if (lit.begin()[i] != 0) map.begin()[i] = gamma_from_harmonics(pixel.B_1(), pixel.B_2());
  }
  return map;
}

GammaEstimate robust_gamma(const Image<double>& map) {
  const std::vector<double> gammas = finite_values(map);
  constexpr std::size_t fewest = 100;
  throw_if(gammas.size() < fewest, "{} pixels are lit and unsaturated; gamma requires at least {}",
           gammas.size(), fewest);

  double centre = median(gammas);
  const double scale = std::max(robust_deviation(gammas, centre), 1e-12);
  GammaEstimate estimate{.pixels = gammas.size()};

  for (int i = 0; i < 20; ++i) {
    double weights = 0, sum = 0, squares = 0, squared_weights = 0;
    for (const double gamma : gammas) {
      const double weight = tukey_weight((gamma - centre) / scale);
      weights += weight;
      sum += weight * gamma;
      squares += weight * (gamma - centre) * (gamma - centre);
      squared_weights += weight * weight;
    }

    centre = sum / weights;
    estimate.spread = std::sqrt(squares / weights);
    estimate.standard_error = estimate.spread * std::sqrt(squared_weights) / weights;
  }

  estimate.gamma = centre;
  return estimate;
}

GammaCalibration calibrate_gamma(const ScanAverage& scans, double minimum_modulation) {
  const Strategy& strategy = scans.sequence.strategy;
  const std::vector<StepRun> runs = step_runs(strategy);
  throw_if(runs.empty(), "{}: measuring gamma requires a run of phase steps", strategy.name());

  const StepRun run = *std::ranges::max_element(runs, {}, &StepRun::steps);
  const FrameSet frames = scans.frames.mean();
  const auto pixels = pixel_harmonics(frames, run.first, run.steps);
  Image<std::uint8_t> lit = well_lit(pixels, frames, minimum_modulation);

  // Averaging hides a saturation that not every scan has.
  const Image<std::uint8_t>& saturated = scans.frames.saturated();
  for (std::size_t i = 0; i < lit.pixel_count(); ++i) {
    if (saturated.begin()[i] != 0) lit.begin()[i] = 0;
  }

  GammaCalibration found{.steps = run.steps, .fit = find_gamma(pixels, lit, run.steps)};
  throw_if(found.fit.refusal == BlindRefusal::too_few_pixels,
           "{}; use brighter patterns or a longer exposure", reason_of(found.fit.refusal));
  add_response(found, pixels, lit, frames, run);

  // Fewer steps alias too much onto the second harmonic.
  if (run.steps >= 5) found.pixels = gamma_of_pixels(pixels, lit);
  return found;
}

MeasuredResponse found_response(const GammaCalibration& calibration) {
  const auto& [steps, fit, misfit, response, pixels] = calibration;
  if (response) {
    return {response->response, std::clamp(fit.gamma, least_gamma, largest_gamma),
            fit.standard_error};
  }

  const std::string what = is_power_law(fit) || fit.refusal == BlindRefusal::no_power_law
                               ? fmt::format("no gamma{} fits: {:.2g} rad of phase error remain",
                                             steps < 8 ? "" : ", sRGB or S-curve", misfit)
                               : std::string(reason_of(fit.refusal));

  throw Error(fmt::format("{}; scan with {} steps or more, or measure the response with `uniform`",
                          what, steps < 8 ? 8 : 12));
}

}  // namespace slipstream
