#include "slipstream/gamma/blind.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "slipstream/gamma/distortion.h"
#include "slipstream/gamma/response.h"
#include "slipstream/noise/robust.h"

namespace slipstream {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

/// What the second constraint is about, the same at every pixel of that gamma and phase: A / B for
/// N = 3 (4.58), else the second harmonic relative to the fundamental (4.60), (4.61).
Complex second_constraint(int steps, const MeasuredHarmonics& harmonics) {
  const auto& [mean, fundamental, second] = harmonics;
  const double B = harmonics.B_1();
  if (steps == 3) return mean / B;
  return second * std::conj(fundamental * fundamental) / (B * B * B);
}

/// A pixel, or a place on the model's curve. Measured phase and constraint repeat with 2 pi / N and
/// are mirrored within it, so both are brought to [0, pi / N].
struct Sample {
  double measured = 0;    ///< phase, rad, [0, pi / N]
  Complex constraint;     ///< second_constraint
  double modulation = 1;  ///< grey levels: the noise of the constraint goes with its inverse
};

std::vector<Sample> samples_of(const Image<MeasuredHarmonics>& pixels,
                               const Image<std::uint8_t>& lit, int steps) {
  // More say no more: the standard error is by then far below what matters.
  constexpr std::size_t most = 40000;
  const auto lit_count = static_cast<std::size_t>(std::count(lit.begin(), lit.end(), 1));
  const double stride = std::max(1.0, static_cast<double>(lit_count) / most);
  const double period = 2 * pi / steps;
  std::vector<Sample> samples;
  double next = 0;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < pixels.pixel_count(); ++i) {
    if (lit.begin()[i] == 0 || static_cast<double>(seen++) < next) continue;
    next += stride;
    const MeasuredHarmonics& pixel = pixels.begin()[i];
    const double phase = std::arg(pixel.fundamental);
    double within = phase - period * std::floor(phase / period);
    Complex constraint = second_constraint(steps, pixel);
    if (within > period / 2) {
      within = period - within;
      constraint = std::conj(constraint);
    }
    samples.push_back({within, constraint, pixel.B_1()});
  }
  std::sort(samples.begin(), samples.end(),
            [](const Sample& a, const Sample& b) { return a.measured < b.measured; });
  return samples;
}

/// The curve on which all pixels of that gamma lie, in `count` pieces of one length in true phase.
std::vector<Sample> model_curve(double gamma, int steps, int count) {
  const Response response = PowerLaw{gamma};
  std::vector<Sample> curve;
  for (int i = 0; i <= count; ++i) {
    const double phi = pi / steps * i / count;
    const MeasuredHarmonics harmonics = measured_harmonics(response, steps, phi);
    const double error = std::arg(harmonics.fundamental * std::polar(1.0, -phi));
    curve.push_back({phi + error, second_constraint(steps, harmonics), 1});
  }
  return curve;
}

/// The constraint that the gamma predicts at each sample's measured phase. Both rise, so one walk
/// along the curve serves all.
std::vector<Complex> predicted(const std::vector<Sample>& samples, double gamma, int steps,
                               int pieces) {
  const std::vector<Sample> curve = model_curve(gamma, steps, pieces);
  std::vector<Complex> constraints;
  constraints.reserve(samples.size());
  std::size_t piece = 0;
  for (const Sample& sample : samples) {
    while (piece + 2 < curve.size() && curve[piece + 1].measured < sample.measured) ++piece;
    const Sample &left = curve[piece], &right = curve[piece + 1];
    const double width = right.measured - left.measured;
    const double share =
        width > 0 ? std::clamp((sample.measured - left.measured) / width, 0.0, 1.0) : 0;
    constraints.push_back(left.constraint + share * (right.constraint - left.constraint));
  }
  return constraints;
}

constexpr int coarse_pieces = 256;
constexpr int fine_pieces = 8192;

/// Half of the pixels are nearer to that gamma than this, grey levels.
double median_residual(const std::vector<Sample>& samples, const std::vector<Complex>& model) {
  std::vector<double> residuals;
  residuals.reserve(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    residuals.push_back(std::abs(samples[i].constraint - model[i]) * samples[i].modulation);
  }
  return median(std::move(residuals));
}

/// The gamma that most pixels agree on, within 1 %.
double agreed_gamma(const std::vector<Sample>& samples, int steps) {
  const int count = static_cast<int>(std::ceil(std::log(largest_gamma / least_gamma) / 0.02));
  double best_gamma = 1, best = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= count; ++i) {
    const double gamma =
        least_gamma * std::pow(largest_gamma / least_gamma, static_cast<double>(i) / count);
    const double residual =
        median_residual(samples, predicted(samples, gamma, steps, coarse_pieces));
    if (residual < best) {
      best = residual;
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
/// of every pixel may hold the same light besides the pattern's (N = 3).
Fit fitted(const std::vector<Sample>& samples, int steps, double gamma, Offset offset) {
  Fit fit{.gamma = gamma};
  for (int round = 0; round < 60; ++round) {
    const double h = 1e-3 * fit.gamma;
    const auto model = predicted(samples, fit.gamma, steps, fine_pieces);
    const auto below = predicted(samples, fit.gamma - h, steps, fine_pieces);
    const auto above = predicted(samples, fit.gamma + h, steps, fine_pieces);
    // In grey levels: residual r, its slopes with gamma, J, and with the offset, 1.
    const auto residual = [&](std::size_t i) {
      return (samples[i].constraint - model[i]) * samples[i].modulation -
             (offset == Offset::free ? fit.offset : 0);
    };
    const auto slope = [&](std::size_t i) {
      return (above[i] - below[i]) * (samples[i].modulation / (2 * h));
    };
    std::vector<double> sizes;
    sizes.reserve(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) sizes.push_back(std::abs(residual(i)));
    const double scale = std::max(deviation_from_median(median(sizes)), 1e-10);

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

    double scatter = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double weight = tukey_weight(sizes[i] / scale);
      const Complex along = std::conj(slope(i) * weights - free * J1) * residual(i);
      scatter += weight * weight * along.real() * along.real();
    }
    fit.standard_error = std::sqrt(scatter) / determinant;
    const double limited = std::clamp(step, -0.1 * fit.gamma, 0.1 * fit.gamma);
    fit.gamma = std::clamp(fit.gamma + limited, least_gamma / 2, 2 * largest_gamma);
    if (std::abs(step) < 1e-9) break;
  }
  return fit;
}

/// What is left of the constraint, as a share of what the gamma explains of it: RMS over bins of
/// the measured phase, the median in each, so that noise does not count.
double systematic_misfit(const std::vector<Sample>& samples, double gamma, int steps) {
  constexpr std::size_t bins = 24, fewest = 10;
  const auto model = predicted(samples, gamma, steps, fine_pieces);
  const auto linear = predicted(samples, 1, steps, coarse_pieces);
  std::vector<std::vector<std::size_t>> members(bins);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double place = samples[i].measured * steps / pi * bins;
    members[std::min(static_cast<std::size_t>(place), bins - 1)].push_back(i);
  }
  double left = 0, explained = 0;
  for (const auto& bin : members) {
    if (bin.size() < fewest) continue;
    std::vector<double> real, imaginary, real_model, imaginary_model;
    for (const std::size_t i : bin) {
      real.push_back((samples[i].constraint - model[i]).real());
      imaginary.push_back((samples[i].constraint - model[i]).imag());
      real_model.push_back((model[i] - linear[i]).real());
      imaginary_model.push_back((model[i] - linear[i]).imag());
    }
    left += std::norm(Complex(median(real), median(imaginary)));
    explained += std::norm(Complex(median(real_model), median(imaginary_model)));
  }
  return explained > 0 ? std::sqrt(left / explained) : 0;
}

/// Whether light that is not the pattern's, if there is any, leaves gamma as it was found.
bool survives_ambient_light(const std::vector<Sample>& samples, const Fit& fit, double tolerance) {
  const Fit with_offset = fitted(samples, 3, fit.gamma, Offset::free);
  return std::abs(with_offset.gamma - fit.gamma) <= tolerance &&
         3 * with_offset.standard_error <= tolerance;
}

}  // namespace

std::string_view reason_of(BlindRefusal refusal) {
  switch (refusal) {
    case BlindRefusal::none:
      return "gamma found";
    case BlindRefusal::too_few_pixels:
      return "too few pixels are lit and not saturated";
    case BlindRefusal::ambient_light:
      return "ambient light, which three steps cannot tell from gamma";
    case BlindRefusal::no_distortion:
      return "no distortion to see";
    case BlindRefusal::no_power_law:
      return "the response follows no gamma in range";
  }
  return "";
}

BlindGamma find_gamma(const Image<MeasuredHarmonics>& pixels, const Image<std::uint8_t>& lit,
                      int steps) {
  constexpr std::size_t fewest_pixels = 100;
  constexpr double largest_misfit = 0.25, ambient_tolerance = 0.03, negligible = 1e-3;
  const std::vector<Sample> samples = samples_of(pixels, lit, steps);
  BlindGamma found{.pixels = samples.size()};
  if (samples.size() < fewest_pixels) {
    found.refusal = BlindRefusal::too_few_pixels;
    return found;
  }
  const Fit fit = fitted(samples, steps, agreed_gamma(samples, steps), Offset::none);
  found.gamma = fit.gamma;
  found.standard_error = fit.standard_error;
  if (steps == 3 && !survives_ambient_light(samples, fit, ambient_tolerance * fit.gamma)) {
    found.refusal = BlindRefusal::ambient_light;
  } else if (std::abs(fit.gamma - 1) <= std::max(3 * fit.standard_error, negligible)) {
    found.refusal = BlindRefusal::no_distortion;
  } else if (!(fit.gamma >= least_gamma && fit.gamma <= largest_gamma) ||
             systematic_misfit(samples, fit.gamma, steps) > largest_misfit) {
    found.refusal = BlindRefusal::no_power_law;
  }
  return found;
}

BlindGamma find_gamma(const FrameViews& frames, int first, int steps) {
  const Image<MeasuredHarmonics> pixels = pixel_harmonics(frames, first, steps);
  return find_gamma(pixels, well_lit(pixels, frames), steps);
}

}  // namespace slipstream
