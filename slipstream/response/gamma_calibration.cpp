#include "slipstream/response/gamma_calibration.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

bool is_power_law(const BlindGamma& fit) {
  return fit.accepted() || fit.refusal == BlindRefusal::no_distortion;
}

StepRun longest_run(const Sequence& sequence) {
  std::optional<StepRun> longest;
  for (const Band& band : sequence.strategy.layout().bands) {
    const auto run = step_run(band);
    if (run && (!longest || run->steps > longest->steps)) longest = run;
  }
  if (longest) return *longest;
  throw Error(fmt::format("{}: no run of phase steps in it, by which gamma is measured",
                          sequence.strategy.name()));
}

PixelGamma gamma_of_pixels(const Image<MeasuredHarmonics>& pixels, const Image<std::uint8_t>& lit) {
  PixelGamma found{.map = gamma_map(pixels, lit)};
  found.estimate = robust_gamma(found.map);
  const double reach = std::max(5 * found.estimate.spread, 1e-3);
  found.histogram =
      histogram(found.map, found.estimate.gamma - reach, found.estimate.gamma + reach, 50);
  return found;
}

/// What lit pixels see of the sinusoid, by its value: the mean over all of them and all frames,
/// each pixel's mean and modulation taken out.
ResponseCurve curve_seen(const FrameViews& frames, const Image<MeasuredHarmonics>& pixels,
                         const Image<std::uint8_t>& lit, const StepRun& run) {
  constexpr int pieces = 64;  // of half a period
  constexpr double pi = std::numbers::pi;
  std::vector<double> sum(pieces + 1), count(pieces + 1), values, levels;
  for (int n = 0; n < run.steps; ++n) {
    std::vector<double> only(static_cast<std::size_t>(frames.count()));
    only[static_cast<std::size_t>(run.first + n)] = 1;
    const Image<double> level = weighted_sum(frames, only);
    for (std::size_t i = 0; i < lit.pixel_count(); ++i) {
      if (lit.begin()[i] == 0) continue;
      const MeasuredHarmonics& pixel = pixels.begin()[i];
      const double angle = std::arg(pixel.fundamental) - 2 * pi * n / run.steps;
      const double folded = std::abs(std::remainder(angle, 2 * pi));
      const auto piece = static_cast<std::size_t>(std::lround(folded / pi * pieces));
      sum[piece] += (level.begin()[i] - pixel.mean) / std::abs(pixel.fundamental);
      ++count[piece];
    }
  }
  for (int i = pieces; i >= 0; --i) {
    const auto piece = static_cast<std::size_t>(i);
    values.push_back(i == pieces ? 0 : 0.5 + 0.5 * std::cos(pi * i / pieces));
    levels.push_back(sum[piece] / std::max(count[piece], 1.0));
  }
  return response_curve(values, levels);
}

/// Adds misfit and response.
void add_response(GammaCalibration& found, const Image<MeasuredHarmonics>& pixels,
                  const Image<std::uint8_t>& lit, const FrameViews& frames, const StepRun& run) {
  constexpr int fewest_for_curve = 8;
  // With fewer, the harmonics that the phases themselves are bent by blur the curve.
  constexpr int fewest_for_seen = 12;
  constexpr double most_left = 0.05;  // of what no correction leaves
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
    const Response seen = curve_seen(frames, pixels, lit, run);
    if (misfit(curve, seen) < most_left * misfit(curve, PowerLaw{1})) {
      found.response = NamedResponse{"measured curve", seen};
    }
  }
}

}  // namespace

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
  if (gammas.size() < fewest) {
    throw Error(fmt::format("{} pixels are lit and not saturated; gamma takes at least {}",
                            gammas.size(), fewest));
  }
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
  const StepRun run = longest_run(scans.sequence());
  const FrameSet frames = scans.frames().mean();
  const auto pixels = pixel_harmonics(frames, run.first, run.steps);
  Image<std::uint8_t> lit = well_lit(pixels, frames, minimum_modulation);
  const Image<std::uint8_t>& saturated = scans.frames().saturated();
  for (std::size_t i = 0; i < lit.pixel_count(); ++i) {
    if (saturated.begin()[i] != 0) lit.begin()[i] = 0;
  }
  GammaCalibration found{.steps = run.steps, .fit = find_gamma(pixels, lit, run.steps)};
  if (found.fit.refusal == BlindRefusal::too_few_pixels) {
    throw Error(fmt::format("{}; show the patterns brighter or expose longer",
                            reason_of(found.fit.refusal)));
  }
  add_response(found, pixels, lit, frames, run);
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
                               ? fmt::format("no gamma{} fits, {:.2g} rad of phase are left over",
                                             steps < 8 ? "" : ", sRGB or S-curve", misfit)
                               : std::string(reason_of(fit.refusal));
  throw Error(fmt::format("{}; scan with {} steps or more, or measure the response with --uniform",
                          what, steps < 8 ? 8 : 12));
}

}  // namespace slipstream
