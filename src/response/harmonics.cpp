#include "response/harmonics.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "decode/phase_decoder.h"

namespace slipstream {
namespace {

using std::numbers::pi;

using Complex = std::complex<double>;

// Pieces of the model's curve for the few bins of a ConstraintCurve.
constexpr int pieces = 1024;

Constraint constraint_of(int steps, const MeasuredHarmonics& harmonics) {
  constexpr int fewest_for_third = 6;
  const double B = harmonics.B_1();

  // The rotation that makes the fundamental real, applied once per order of a harmonic.
  const Complex back = std::conj(harmonics.fundamental) / B, mean = harmonics.mean / B;
  return {steps == 3 ? mean : harmonics.second * back * back / B,
          steps < fewest_for_third ? 0 : harmonics.third * back * back * back / B, mean};
}

/// The curve of all pixels under that response, in `count` pieces of equal length in true phase.
std::vector<HarmonicSample> model_curve(const Response& response, int steps, int count) {
  std::vector<HarmonicSample> curve;
  for (int i = 0; i <= count; ++i) {
    const double phi = 2 * pi / steps * i / count;

    // Measured minus true phase: too small to wrap.
    const MeasuredHarmonics harmonics = measured_harmonics(response, steps, phi);
    const double error = std::arg(harmonics.fundamental * std::polar(1.0, -phi));
    curve.push_back({phi + error, constraint_of(steps, harmonics), 1});
  }

  return curve;
}

/// Median, and robust variance of one value.
struct Middle {
  Complex value;
  double variance = 0;
};

Middle middle_of(const std::vector<Complex>& values) {
  Middle middle;

  // The median of one part of the numbers; adds its variance to the sum.
  const auto middle_part = [&](const auto& part) {
    std::vector<double> numbers;
    for (const Complex& value : values) numbers.push_back(part(value));
    const double centre = median(numbers);
    middle.variance += std::pow(robust_deviation(numbers, centre), 2);
    return centre;
  };

  const double real = middle_part([](const Complex& value) { return value.real(); });
  middle.value = {real, middle_part([](const Complex& value) { return value.imag(); })};
  return middle;
}

}  // namespace

Image<MeasuredHarmonics> pixel_harmonics(const FrameViews& frames, int first, int steps) {
  // Frame n turns the harmonic h by h n / N of a turn.
  std::vector<std::complex<double>> turns(steps);
  for (std::size_t n = 0; n < turns.size(); ++n) {
    turns[n] = std::polar(1.0, 2 * pi * static_cast<double>(n) / steps);
  }

  Image<MeasuredHarmonics> pixels(frames.size());
  frames.part(first, steps).visit([&](const auto& views) {
    const auto N = views.size();
    for_each_pixel(frames.size(), [&](int column, int row) {
      MeasuredHarmonics& pixel = pixels(column, row);

      for (std::size_t n = 0; n < N; ++n) {
        const auto I_n = static_cast<double>(views[n](column, row));
        pixel.mean += I_n;
        pixel.fundamental += I_n * turns[n];
        pixel.second += I_n * turns[2 * n % N];
        pixel.third += I_n * turns[3 * n % N];
      }

      // A Fourier coefficient is twice the mean product, except for the constant term.
      const auto count = static_cast<double>(N);
      pixel.mean /= count;
      pixel.fundamental *= 2 / count;
      pixel.second *= 2 / count;
      pixel.third *= 2 / count;
    });
  });

  return pixels;
}

Image<std::uint8_t> well_lit(const Image<MeasuredHarmonics>& pixels, const FrameViews& frames,
                             double minimum) {
  const double least = minimum > 0 ? minimum : frames.full_scale() / 16;
  const Image<std::uint8_t> saturated = saturation_mask(frames);
  Image<std::uint8_t> lit(pixels.size());

  for (std::size_t i = 0; i < pixels.pixel_count(); ++i) {
    lit.begin()[i] = pixels.begin()[i].B_1() >= least && saturated.begin()[i] == 0 ? 1 : 0;
  }
  return lit;
}

MeasuredHarmonics measured_harmonics(const Response& response, int steps, double phi) {
  MeasuredHarmonics harmonics;

  for (int n = 0; n < steps; ++n) {
    const double I_n = light_at(response, 0.5 + 0.5 * std::cos(phi - 2 * pi * n / steps));  // (4.2)
    const std::complex<double> turn = std::polar(1.0, 2 * pi * n / steps);

    harmonics.mean += I_n / steps;
    harmonics.fundamental += 2.0 / steps * I_n * turn;
    harmonics.second += 2.0 / steps * I_n * turn * turn;
    harmonics.third += 2.0 / steps * I_n * turn * turn * turn;
  }

  return harmonics;
}

std::vector<HarmonicSample> harmonic_samples(const Image<MeasuredHarmonics>& pixels,
                                             const Image<std::uint8_t>& lit, int steps) {
  // More add nothing: the standard error is then far below any tolerance.
  constexpr std::size_t most = 40000;
  const auto lit_count = static_cast<std::size_t>(std::ranges::count(lit, 1));
  const double stride = std::max(1.0, static_cast<double>(lit_count) / most);
  const double period = 2 * pi / steps;

  std::vector<HarmonicSample> samples;
  double next = 0;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < pixels.pixel_count(); ++i) {
    if (lit.begin()[i] == 0 || static_cast<double>(seen++) < next) continue;
    next += stride;

    // Relative harmonics repeat after a step, so that all samples fit into one.
    const MeasuredHarmonics& pixel = pixels.begin()[i];
    const double phase = std::arg(pixel.fundamental);
    samples.push_back(
        {phase - period * std::floor(phase / period), constraint_of(steps, pixel), pixel.B_1()});
  }

  std::ranges::sort(samples, {}, &HarmonicSample::measured);
  return samples;
}

std::vector<Constraint> predicted(const std::vector<HarmonicSample>& samples,
                                  const Response& response, int steps, int count) {
  // Both are increasing, so one pass along the curve is enough.
  const std::vector<HarmonicSample> curve = model_curve(response, steps, count);

  std::vector<Constraint> constraints;
  constraints.reserve(samples.size());
  std::size_t piece = 0;
  for (const HarmonicSample& sample : samples) {
    while (piece + 2 < curve.size() && curve[piece + 1].measured < sample.measured) ++piece;
    const HarmonicSample &left = curve[piece], &right = curve[piece + 1];

    // Linear interpolation between the two points around the sample.
    const double width = right.measured - left.measured;
    const double share =
        width > 0 ? std::clamp((sample.measured - left.measured) / width, 0.0, 1.0) : 0;
    const auto between = [&](Complex Constraint::*part) {
      return left.constraint.*part + share * (right.constraint.*part - left.constraint.*part);
    };

    constraints.push_back(
        {between(&Constraint::second), between(&Constraint::third), between(&Constraint::mean)});
  }

  return constraints;
}

ConstraintCurve constraint_curve(const std::vector<HarmonicSample>& samples, const Response& near,
                                 int steps) {
  // 5 to 48 bins, if possible with twice the samples that each requires.
  constexpr std::size_t fewest = 10;
  const std::size_t bins = std::clamp<std::size_t>(samples.size() / (2 * fewest), 5, 48);
  const std::vector<Constraint> model = predicted(samples, near, steps);

  ConstraintCurve curve{.steps = steps};
  double noise = 0;
  for (std::size_t bin = 1, first = 0, end = 0; bin <= bins; ++bin, first = end) {
    const double limit = 2 * pi / steps * static_cast<double>(bin) / static_cast<double>(bins);
    while (end < samples.size() && (bin == bins || samples[end].measured < limit)) ++end;
    if (end - first < fewest) continue;

    // The bin's place and modulation: its middle sample, and the median.
    const std::size_t centre = std::midpoint(first, end);
    HarmonicSample& middle = curve.bins.emplace_back(samples[centre]);
    std::vector<double> modulations;
    for (std::size_t i = first; i < end; ++i) modulations.push_back(samples[i].modulation);
    middle.modulation = median(std::move(modulations));

    // Its harmonics: the model's at that place, plus the median distance from the model. The
    // difference hardly varies within a bin, unlike the harmonics themselves.
    for (const auto part : {&Constraint::second, &Constraint::third, &Constraint::mean}) {
      std::vector<Complex> left;
      for (std::size_t i = first; i < end; ++i) {
        left.push_back(samples[i].constraint.*part - model[i].*part);
      }

      const auto [value, variance] = middle_of(left);
      middle.constraint.*part = model[centre].*part + value;

      // The mean depends on ambient light, and does not count as noise.
      if (part == &Constraint::mean) continue;
      noise += variance;
      curve.variance += pi / 2 * variance / static_cast<double>(left.size());  // of a median
    }
  }

  const auto count = static_cast<double>(std::max<std::size_t>(curve.bins.size(), 1));
  curve.variance /= count;
  curve.noise = std::sqrt(noise / count);
  return curve;
}

double distance(const ConstraintCurve& curve, const Response& response) {
  if (curve.bins.empty()) return std::numeric_limits<double>::infinity();

  const std::vector<Constraint> model = predicted(curve.bins, response, curve.steps, pieces);
  double sum = 0;
  for (std::size_t i = 0; i < model.size(); ++i) {
    sum += std::norm(curve.bins[i].constraint.second - model[i].second) +
           std::norm(curve.bins[i].constraint.third - model[i].third);
  }

  return sum / static_cast<double>(model.size());
}

double misfit(const ConstraintCurve& curve, const Response& response) {
  return std::sqrt(std::max(0.0, distance(curve, response) - curve.variance));
}

double harmless_misfit(const ConstraintCurve& curve) {
  return std::max(0.002, 0.2 * curve.noise);
}

double misfit_of_mean(const ConstraintCurve& curve, const Response& response) {
  const std::vector<Constraint> model = predicted(curve.bins, response, curve.steps, pieces);

  // A = m B + offset: least squares of A / B - m = offset / B.
  double left = 0, product = 0, square = 0;
  for (std::size_t i = 0; i < model.size(); ++i) {
    const double beyond = (curve.bins[i].constraint.mean - model[i].mean).real();
    const double share = 1 / curve.bins[i].modulation;
    left += beyond * beyond;
    product += beyond * share;
    square += share * share;
  }

  const double without_offset = left - product * product / square;
  return std::sqrt(std::max(0.0, without_offset) / static_cast<double>(model.size()));
}

}  // namespace slipstream
