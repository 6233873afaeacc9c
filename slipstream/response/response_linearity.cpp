#include "slipstream/response/response_linearity.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "slipstream/response/pixel_harmonics.h"

namespace slipstream {
namespace {

using std::numbers::pi;

std::optional<StepRun> first_run_of_four(const Layout& layout) {
  constexpr int fewest_steps = 4;
  for (const Band& band : layout.bands) {
    const auto run = step_run(band);
    if (run && run->steps >= fewest_steps) return run;
  }
  return std::nullopt;
}

/// Light of the patterns at an angle of their sinusoid, grey levels of 255.
double light_at_angle(const PatternLight& light, const Response& response, double angle) {
  const double value = light.alpha_p * (1 + std::cos(angle)) / 2 + light.beta_p;
  return 255 * light_at(response, value / 255);
}

/// What a second harmonic as large as the first would be measured as.
std::complex<double> whole_second(const MeasuredHarmonics& pixel, int steps) {
  const std::complex<double> whole = pixel.fundamental * pixel.fundamental / pixel.B_1();
  // Four steps fold the harmonic -2 onto it.
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

}  // namespace

PatternLight linear_equivalent(const PatternLight& light, const Response& response) {
  constexpr int samples = 720;  // harmonics up to 700 are not folded in
  double mean = 0, first = 0;
  for (int i = 0; i < samples; ++i) {
    const double angle = 2 * pi * i / samples;
    const double shown = light_at_angle(light, response, angle);
    mean += shown / samples;
    first += 2 * shown * std::cos(angle) / samples;
  }
  return {2 * first, mean - first};
}

double second_harmonic(const PatternLight& light, const Response& response, int steps) {
  constexpr int phases = 90;
  ShareFit fit;
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
  const auto run = first_run_of_four(scans.sequence().strategy.layout());
  if (!run) return std::nullopt;
  const FrameSet frames = scans.frames().mean();
  const auto pixels = pixel_harmonics(frames, run->first, run->steps);
  const Image<std::uint8_t> lit = well_lit(pixels, frames);
  ResponseLinearity found{.steps = run->steps};
  ShareFit fit;
  const auto serves = [&](std::size_t i) {
    return lit.begin()[i] != 0 && scans.unclipped().begin()[i] != 0;
  };
  for (std::size_t i = 0; i < pixels.pixel_count(); ++i) {
    if (!serves(i)) continue;
    fit.add(pixels.begin()[i], run->steps);
    ++found.pixels;
  }
  if (found.pixels < fewest_pixels) return std::nullopt;
  found.second = fit.share();
  double residual = 0;
  for (std::size_t i = 0; i < pixels.pixel_count(); ++i) {
    if (!serves(i)) continue;
    const MeasuredHarmonics& pixel = pixels.begin()[i];
    residual += std::norm(pixel.second - found.second * whole_second(pixel, run->steps));
  }
  found.standard_error = std::sqrt(residual / static_cast<double>(found.pixels) / fit.square);
  return found;
}

bool has_second_harmonic(const ResponseLinearity& linearity, double share) {
  // By a power law a share of 0.004 is a gamma of 1.012, and moves the mean by 0.6 % of the
  // modulation, which is a hundred grey levels at most; at a gamma of 2.2 three hundredths of the
  // share do as much.
  constexpr double negligible = 0.004, negligible_part = 0.03, deviations = 5;
  return std::abs(linearity.second - share) <=
         std::max({negligible, negligible_part * std::abs(share),
                   deviations * linearity.standard_error});
}

}  // namespace slipstream
