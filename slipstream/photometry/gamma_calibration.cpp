#include "slipstream/photometry/gamma_calibration.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/gamma/harmonic_samples.h"

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

/// Adds misfit and response.
void add_response(GammaCalibration& found, const Image<MeasuredHarmonics>& pixels,
                  const Image<std::uint8_t>& lit) {
  constexpr int fewest_for_curve = 8;
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
}

}  // namespace

GammaCalibration calibrate_gamma(const ScanAverage& scans, double minimum_modulation) {
  const StepRun run = longest_run(scans.sequence());
  const FrameSet frames = scans.frames().mean();
  const auto pixels = pixel_harmonics(frames, run.first, run.steps);
  Image<std::uint8_t> lit = well_lit(pixels, frames, minimum_modulation);
  const Image<std::uint8_t>& saturated = scans.frames().saturated();
  std::transform(lit.begin(), lit.end(), saturated.begin(), lit.begin(),
                 [](std::uint8_t is_lit, std::uint8_t is_saturated) {
                   return static_cast<std::uint8_t>(is_lit != 0 && is_saturated == 0 ? 1 : 0);
                 });
  GammaCalibration found{.steps = run.steps, .fit = find_gamma(pixels, lit, run.steps)};
  if (found.fit.refusal == BlindRefusal::too_few_pixels) {
    throw Error(fmt::format("{}; show the patterns brighter or expose longer",
                            reason_of(found.fit.refusal)));
  }
  add_response(found, pixels, lit);
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
  throw Error(
      fmt::format("{}; scan with 8 steps or more, or measure the response with --uniform", what));
}

}  // namespace slipstream
