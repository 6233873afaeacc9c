#include "response/correction.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numbers>
#include <numeric>
#include <variant>

#include <Eigen/Dense>

#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
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

/// The root of an increasing function in [low, high], with f(low) <= 0 <= f(high), to rounding:
/// false position, with the value of the retained end halved (Illinois) and occasional bisection.
template <class Function>
double root_between(const Function& f, double low, double high) {
  constexpr double rounding = 4e-15;  // of f
  double f_low = f(low), f_high = f(high);

  if (f_low >= 0) return low;
  if (f_high <= 0) return high;

  // Which end the previous iteration replaced: two in a row halve the value at the other end.
  bool moved_low = false, moved_high = false;
  for (int i = 1; i < 200 && high - low > 1e-15; ++i) {
    // Where the straight line through both ends is zero; every eighth time, the middle.
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

double added_at(const Response& response, int steps, double place) {
  const double measured = 2 * pi * place / steps;
  return true_phase(response, steps, measured) - measured;
}

/// The matrix 1, cos, sin with a row per frame whose pseudo-inverse the band's weights of least
/// squares are: its own pseudo-inverse. Rows outside the band's frames are 0.
Eigen::MatrixX3d frames_of(const Band& band) {
  Eigen::Matrix3Xd weights(3, std::ssize(band.mean));

  for (int row = 0; const auto* const part : {&band.mean, &band.cosine, &band.sine}) {
    std::copy(part->begin(), part->end(), weights.row(row++).begin());
  }

  return weights.transpose() * (weights * weights.transpose()).inverse();
}

/// Whether each row has an angle, or is constant light alone: not so with other weights.
bool has_angles(const Eigen::MatrixX3d& frames) {
  constexpr double rounding = 1e-6;

  const auto is_near = [](double a, double b) { return std::abs(a - b) < rounding; };
  const auto rows = frames.rowwise();
  return std::ranges::all_of(rows, [&](const auto& row) {
    const double length = row.template tail<2>().norm();
    return row.isZero() || (is_near(row[0], 1) && (is_near(length, 0) || is_near(length, 1)));
  });
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

double phase_error(const Response& response, int steps, double phi) {
  return -std::arg(measured_harmonics(response, steps, phi).fundamental * std::polar(1.0, -phi));
}

double distorted_phase(const Response& response, int steps, double phi) {
  return phi - phase_error(response, steps, phi);
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

double true_phase(const Response& response, int steps, double measured) {
  return true_phase([&](double phi) { return distorted_phase(response, steps, phi); }, steps,
                    measured);
}

double true_phase(const std::function<double(double)>& distorted, int steps, double measured) {
  // Maps the measured phase to [0, pi / N], where measured and true phase agree at both ends and
  // increase together, and maps the solution back.
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

  // The slope of true over measured phase, from a central difference.
  return 2 * step /
         (distorted_phase(response, steps, phi + step) -
          distorted_phase(response, steps, phi - step));
}

PhaseCorrection phase_correction(const Response& response, int steps, double accuracy) {
  throw_if(steps < 3, "{} steps are out of range; 3 or more", steps);
  if (const auto* law = std::get_if<PowerLaw>(&response)) require_gamma(law->gamma, "gamma");
  constexpr std::size_t shortest = 256, longest = 65536;

  // The first half of the period; the second is its mirror image with opposite sign.
  std::vector<double> half;
  for (std::size_t i = 0; i <= shortest / 2; ++i) {
    half.push_back(added_at(response, steps, static_cast<double>(i) / shortest));
  }

  // Doubles the table until halfway between its entries interpolation is accurate enough.
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

std::optional<PhaseCorrection> phase_correction(const Response& response, const Band& band) {
  constexpr int count = 8192;  // of samples and entries: accurate to 1e-6 rad
  const Eigen::MatrixX3d frames = frames_of(band);
  if (!has_angles(frames) || band.share < 1 || band.carrier > 0) return std::nullopt;

  // 1. The measured phase at evenly spaced true phases.
  std::vector<double> measured;
  for (int i = 0; i <= count; ++i) {
    const double phi = 2 * pi * i / count;
    const Eigen::VectorXd sinusoid =
        frames.rightCols<2>() * Eigen::Vector2d(std::cos(phi), std::sin(phi));

    Complex sum = 0;
    for (Eigen::Index n = 0; n < sinusoid.size(); ++n) {
      sum += light_at(response, 0.5 + 0.5 * sinusoid[n]) * Complex(band.cosine[n], band.sine[n]);
    }
    measured.push_back(phi + std::arg(sum * std::polar(1.0, -phi)));

    // A phase that does not rise has no inverse.
    if (i > 0 && !(measured.back() > measured.end()[-2])) return std::nullopt;
  }

  // 2. Its inverse, by linear interpolation: the true phase at evenly spaced measured phases.
  PhaseCorrection correction{.steps = 1, .added = {}};
  for (int i = 0; i < count; ++i) {
    const double entry = 2 * pi * i / count;

    // The curve starts at phi = 0: it reaches an entry below its first phase a turn later.
    const double sought = entry + 2 * pi * std::ceil((measured.front() - entry) / (2 * pi));
    const auto after = std::upper_bound(measured.begin() + 1, measured.end() - 1, sought);
    const double part = (sought - after[-1]) / (*after - after[-1]);

    const double phi = 2 * pi / count * (static_cast<double>(after - measured.begin()) - 1 + part);
    correction.added.push_back(phi - sought);
  }

  return correction;
}

PhaseCorrections phase_corrections(const Response& response, const Layout& layout,
                                   double accuracy) {
  PhaseCorrections corrections;

  for (const int steps : step_counts(layout)) {
    if (!corrections.contains(steps))
      corrections[steps] = phase_correction(response, steps, accuracy);
  }

  // Bands without equal steps get one common correction, or none if theirs differ.
  for (const Band& band : layout.bands) {
    if (bent_run(band)) continue;

    const auto found = phase_correction(response, band);
    const bool is_shared =
        found &&
        std::ranges::equal(corrections.try_emplace(1, *found).first->second.added, found->added,
                           [](double a, double b) { return std::abs(a - b) < 1e-9; });

    if (!is_shared) {
      corrections.erase(1);
      return corrections;
    }
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
