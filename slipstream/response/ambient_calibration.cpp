#include "slipstream/response/ambient_calibration.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/decode/phase_decoder.h"
#include "slipstream/decode/reflectivity.h"
#include "slipstream/response/response_linearity.h"

namespace slipstream {
namespace {

/// Throws Error where the frames show another response: mean and modulation then say nothing of
/// ambient light.
void require_response(const ScanAverage& scans, const std::optional<Response>& response) {
  const auto linearity = response_linearity(scans);
  if (!linearity) return;
  const double expected =
      response ? second_harmonic(scans.sequence().light, *response, linearity->steps) : 0;
  if (has_second_harmonic(*linearity, expected)) return;
  const double percent = 100 * linearity->second;
  if (response) {
    throw Error(
        fmt::format("the frames do not show the response in the scanner file (second harmonic "
                    "{:.2g} % of the first, not {:.2g} %); calibrate gamma again first",
                    percent, 100 * expected));
  }
  throw Error(
      fmt::format("the response is not linear (second harmonic {:.2g} % of the first), which reads "
                  "as ambient light; calibrate gamma into the scanner file first (slipstream "
                  "calibrate gamma), then give that file with --scanner",
                  percent));
}

}  // namespace

void require_ambient_measurable(const Scan& scan, const std::string& name) {
  if (scan.exposures.size() > 1) {
    throw Error(fmt::format("{}: {} exposures; ambient light is measured with one", name,
                            scan.exposures.size()));
  }
  const Strategy& strategy = scan.sequence.strategy;
  const Layout& layout = strategy.layout();
  if (layout.unwrapping != Unwrapping::vote && carrier_periods(strategy) == 0) return;
  throw Error(
      fmt::format("{}: {}; ambient light is measured with patterns that hold no cue and no carrier",
                  name, strategy.name()));
}

AmbientCalibration calibrate_ambient(const ScanAverage& scans, double least_alpha,
                                     const std::optional<Response>& response) {
  if (!(least_alpha > 0 && least_alpha <= 1)) {
    throw Error(
        fmt::format("--least-reflectivity {} is out of range; above 0, at most 1", least_alpha));
  }
  const Sequence& sequence = scans.sequence();
  require_response(scans, response);
  const Band& band = sequence.strategy.layout().bands.front();
  const PhaseMaps maps = PhaseDecoder(PhaseMethod::equation, {})(scans.frames().mean(), band);
  const PatternLight light =
      response ? linear_equivalent(sequence.light, *response) : sequence.light;
  const Image<double> map =
      ambient_map(maps.mean, maps.modulation, light, least_alpha, scans.unclipped());
  AmbientCalibration found{.estimate = ambient_estimate(map)};
  const double reach = std::max(1.0, 5 * std::sqrt(found.estimate.variance));
  found.histogram =
      histogram(map, found.estimate.median - reach, found.estimate.median + reach, 60);
  found.least_reliable_alpha =
      least_reliable_reflectivity(sequence.light.beta_p, found.estimate.mode);
  return found;
}

}  // namespace slipstream
