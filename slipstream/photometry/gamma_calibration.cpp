#include "slipstream/photometry/gamma_calibration.h"

#include <algorithm>

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream {
namespace {

StepRun first_run(const Sequence& sequence) {
  for (const Band& band : sequence.strategy.layout().bands) {
    if (const auto run = step_run(band)) return *run;
  }
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

}  // namespace

GammaCalibration calibrate_gamma(const ScanAverage& scans, double minimum_modulation) {
  const StepRun run = first_run(scans.sequence());
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
  if (run.steps >= 5) found.pixels = gamma_of_pixels(pixels, lit);
  return found;
}

void require_found(const GammaCalibration& calibration) {
  const BlindGamma& fit = calibration.fit;
  if (fit.accepted() || fit.refusal == BlindRefusal::no_distortion) return;
  throw Error(
      fmt::format("{}; scan with at least 5 steps, or measure the response with --uniform "
                  "and --response",
                  reason_of(fit.refusal)));
}

}  // namespace slipstream
