#include "response/ambient_calibration.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "decode/equations.h"
#include "decode/phase_decoder.h"
#include "response/harmonics.h"
#include "response/scan_average.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

using std::numbers::pi;

/// Light of the patterns at an angle of their sinusoid, grey levels of 255.
double light_at_angle(const PatternLight& light, const Response& response, double angle) {
  const double value = light.alpha_p * (1 + std::cos(angle)) / 2 + light.beta_p;
  return 255 * light_at(response, value / 255);
}

/// The linear patterns with the mean and modulation of the light that a response produces from
/// sinusoidal ones; beta_p may be negative.
PatternLight linear_equivalent(const PatternLight& light, const Response& response) {
  constexpr int samples = 720;  // no aliasing of harmonics up to 700
  double mean = 0, first = 0;
  for (int i = 0; i < samples; ++i) {
    const double angle = 2 * pi * i / samples;
    const double shown = light_at_angle(light, response, angle);
    mean += shown / samples;
    first += 2 * shown * std::cos(angle) / samples;
  }

  // A linear sinusoid has the mean alpha_p / 2 + beta_p and the modulation alpha_p / 2.
  return {2 * first, mean - first};
}

/// The measured value of a second harmonic as large as the first.
std::complex<double> whole_second(const MeasuredHarmonics& pixel, int steps) {
  const std::complex<double> whole = pixel.fundamental * pixel.fundamental / pixel.B_1();
  // Four steps alias the harmonic -2 onto it.
  return steps == 4 ? 2 * whole.real() : whole;
}

/// Least squares of second harmonic = share x whole_second.
struct ShareFit {
  double product = 0, square = 0;

  void add(const MeasuredHarmonics& pixel, int steps) {
    const std::complex<double> whole = whole_second(pixel, steps);
    product += (std::conj(whole) * pixel.second).real();
    square += std::norm(whole);
  }

  [[nodiscard]] double share() const { return product / square; }
};

/// Mean of the values in the fullest interval of one grey level, wherever it starts.
double mode_of(const std::vector<double>& sorted) {
  std::size_t first = 0, best_first = 0, best_count = 0;
  for (std::size_t last = 0; last < sorted.size(); ++last) {
    while (sorted[last] - sorted[first] > 1) ++first;
    if (last - first + 1 > best_count) {
      best_count = last - first + 1;
      best_first = first;
    }
  }

  double sum = 0;
  for (std::size_t i = best_first; i < best_first + best_count; ++i) sum += sorted[i];
  return sum / static_cast<double>(best_count);
}

/// Throws Error if the frames show another response, for which mean and modulation do not give
/// ambient light.
void require_response(const ScanAverage& scans, const std::optional<Response>& response) {
  const auto linearity = response_linearity(scans);
  if (!linearity) return;

  const double expected =
      response ? second_harmonic(scans.sequence.light, *response, linearity->steps) : 0;
  if (has_second_harmonic(*linearity, expected)) return;

  const double percent = 100 * linearity->second;
  throw_if(response.has_value(),
           "the frames do not match the response in the scanner file (second harmonic "
           "{:.2g} % of the first, not {:.2g} %); calibrate gamma again first",
           percent, 100 * expected);
  throw Error(
      fmt::format("the response is not linear (second harmonic {:.2g} % of the first), which looks "
                  "like ambient light; first add gamma to the scanner file "
                  "(`calibrate_gamma()`), then pass that file with `scanner`",
                  percent));
}

}  // namespace

double second_harmonic(const PatternLight& light, const Response& response, int steps) {
  constexpr int phases = 90;
  ShareFit fit;

  // Frames of pixels at phases all around the circle, all harmonics included.
  for (int i = 0; i < phases; ++i) {
    MeasuredHarmonics pixel;
    for (int n = 0; n < steps; ++n) {
      const double turn = 2 * pi * n / steps;
      const double shown = light_at_angle(light, response, 2 * pi * i / phases - turn);
      pixel.fundamental += 2 * shown / steps * std::polar(1.0, turn);
      pixel.second += 2 * shown / steps * std::polar(1.0, 2 * turn);
    }

    fit.add(pixel, steps);
  }

  return fit.share();
}

std::optional<ResponseLinearity> response_linearity(const ScanAverage& scans) {
  constexpr std::size_t fewest_pixels = 100;

  // Three steps alias the second harmonic onto the first.
  const std::vector<StepRun> runs = step_runs(scans.sequence.strategy.layout());
  const auto run = std::ranges::find_if(runs, [](const StepRun& each) { return each.steps >= 4; });
  if (run == runs.end()) return std::nullopt;

  const FrameSet frames = scans.frames.mean();
  const auto pixels = pixel_harmonics(frames, run->first, run->steps);
  const Image<std::uint8_t> serves = in_both(well_lit(pixels, frames), scans.unclipped);

  ResponseLinearity found{.steps = run->steps};
  ShareFit fit;
  for (std::size_t i = 0; i < pixels.pixel_count(); ++i) {
    if (serves.begin()[i] == 0) continue;
    fit.add(pixels.begin()[i], run->steps);
    ++found.pixels;
  }

  if (found.pixels < fewest_pixels) return std::nullopt;
  found.second = fit.share();

  // Standard error of a slope through the origin, from the scatter about the fit.
  double residual = 0;
  for (std::size_t i = 0; i < pixels.pixel_count(); ++i) {
    if (serves.begin()[i] == 0) continue;
    const MeasuredHarmonics& pixel = pixels.begin()[i];
    residual += std::norm(pixel.second - found.second * whole_second(pixel, run->steps));
  }
  found.standard_error = std::sqrt(residual / static_cast<double>(found.pixels) / fit.square);

  return found;
}

bool has_second_harmonic(const ResponseLinearity& linearity, double share) {
  // For a power law a share of 0.004 is a gamma of 1.012, and shifts the mean by 0.6 % of the
  // modulation, which is at most a hundred grey levels; at a gamma of 2.2 three hundredths of the
  // share have the same effect.
  constexpr double negligible = 0.004, negligible_part = 0.03, deviations = 5;
  return std::abs(linearity.second - share) <=
         std::max({negligible, negligible_part * std::abs(share),
                   deviations * linearity.standard_error});
}

Image<double> ambient_map(const Image<double>& mean, const Image<double>& modulation,
                          const PatternLight& light, double least_alpha,
                          const Image<std::uint8_t>& measured) {
  Image<double> map(mean.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < map.pixel_count(); ++i) {
    const double alpha = reflectivity(modulation.begin()[i], light.alpha_p);

    // Negated so that a NaN reflectivity is skipped too.
    if (measured.begin()[i] == 0 || !(alpha >= least_alpha)) continue;

    map.begin()[i] = ambient_light(mean.begin()[i], alpha, light);
  }
  return map;
}

AmbientEstimate ambient_estimate(const Image<double>& map) {
  constexpr std::size_t fewest = 100;

  std::vector<double> values = finite_values(map);
  throw_if(values.size() < fewest,
           "{} pixels are bright enough to measure ambient light; at least {} are required",
           values.size(), fewest);

  std::ranges::sort(values);
  const auto count = static_cast<double>(values.size());
  AmbientEstimate estimate{
      .mode = mode_of(values), .median = values[values.size() / 2], .pixels = values.size()};

  for (const double value : values) estimate.mean += value / count;
  for (const double value : values) {
    const double from_mean = value - estimate.mean;
    estimate.variance += from_mean * from_mean / (count - 1);
  }

  return estimate;
}

void require_ambient_measurable(const Scan& scan, const std::string& name) {
  throw_if(scan.exposures.size() > 1,
           "{}: {} exposures; measuring ambient light requires a single one", name,
           scan.exposures.size());

  const Strategy& strategy = scan.sequence.strategy;
  const Layout& layout = strategy.layout();
  throw_if(order_source(layout) == OrderSource::neighbours || carrier_periods(strategy) != 0,
           "{}: {}; measuring ambient light requires patterns without a cue or carrier", name,
           strategy.name());
}

AmbientCalibration calibrate_ambient(const ScanAverage& scans, double least_alpha,
                                     const std::optional<Response>& response) {
  require_in_range(least_alpha > 0 && least_alpha <= 1, "`least_alpha`", least_alpha,
                   "above 0, at most 1");

  const Sequence& sequence = scans.sequence;
  require_response(scans, response);

  const Band& band = sequence.strategy.layout().bands.front();
  const PhaseMaps maps = PhaseDecoder(PhaseMethod::equation, {})(scans.frames.mean(), band);

  // Mean and modulation suffice for linear patterns that have them in common with the real ones.
  const PatternLight light =
      response ? linear_equivalent(sequence.light, *response) : sequence.light;
  const Image<double> map =
      ambient_map(maps.mean, maps.modulation, light, least_alpha, scans.unclipped);

  AmbientCalibration found{.estimate = ambient_estimate(map)};
  const double reach = std::max(1.0, 5 * std::sqrt(found.estimate.variance));
  found.histogram =
      histogram(map, found.estimate.median - reach, found.estimate.median + reach, 60);
  found.least_reliable_alpha =
      least_reliable_reflectivity(sequence.light.beta_p, found.estimate.mode);

  return found;
}

}  // namespace slipstream
