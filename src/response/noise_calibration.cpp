#include "response/noise_calibration.h"

#include <algorithm>
#include <cmath>

#include "base/throw_if-inl.h"
#include "decode/phase_decoder.h"
#include "response/scan_average.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

/// Variance of `value` over the measured pixels, times `factor`.
template <class Value>
NoiseEstimate scaled_variance(const Image<std::uint8_t>& measured, double factor,
                              const Value& value) {
  constexpr std::size_t fewest = 100;
  double mean = 0, squares = 0;
  std::size_t count = 0;

  for (std::size_t i = 0; i < measured.pixel_count(); ++i) {
    if (measured.begin()[i] == 0) continue;
    ++count;

    // Welford's update: no cancellation of large sums.
    const double x = value(i);
    const double from_mean = x - mean;
    mean += from_mean / static_cast<double>(count);
    squares += from_mean * (x - mean);
  }

  throw_if(count < fewest, "{} pixels are too few to measure noise; at least {} are required",
           count, fewest);

  // The variance of n Gaussian values has a relative standard error of sqrt(2 / (n - 1)).
  const double variance = factor * squares / static_cast<double>(count - 1);
  return {.variance = variance,
          .standard_error = variance * std::sqrt(2.0 / static_cast<double>(count - 1)),
          .pixels = count};
}

constexpr double least_modulation = 8;  // grey levels

/// Adds an estimate to the sums of variances and squared errors.
void add(NoiseMeasurement& sums, const NoiseEstimate& estimate) {
  sums.variance += estimate.variance;
  sums.standard_error += estimate.standard_error * estimate.standard_error;
  sums.pixels = estimate.pixels;
  ++sums.count;
}

bool of_one_band(const Layout& layout) {
  return layout.bands.size() == 1 && !layout.cue;
}

/// Why a measurement differs from the most trusted one; otherwise empty.
std::string disagreement(const NoiseMeasurement& other, const NoiseMeasurement& trusted) {
  const double difference = other.variance - trusted.variance;
  const double error = std::hypot(other.standard_error, trusted.standard_error);
  if (std::abs(difference) < std::max(4 * error, 0.05 * trusted.variance)) return "";

  if (mistakes_gamma_for_noise(other) || other.equation == "3.19") {
    return "the response is not linear, and this counts its effect as noise: calibrate gamma";
  }
  return "light or scene changed unevenly between the scans";
}

}  // namespace

NoiseEstimate noise_from_means(const Image<double>& mean_1, int steps_1,
                               const Image<double>& mean_2, int steps_2,
                               const Image<std::uint8_t>& measured) {
  const double N_1 = steps_1, N_2 = steps_2;
  return scaled_variance(measured, N_1 * N_2 / (N_1 + N_2),
                         [&](std::size_t i) { return mean_1.begin()[i] - mean_2.begin()[i]; });
}

NoiseLine noise_line_from_means(const Image<double>& mean_1, const Image<double>& mean_2, int steps,
                                const Image<std::uint8_t>& measured) {
  const NoiseEstimate all = noise_from_means(mean_1, steps, mean_2, steps, measured);

  double shift = 0;  // light that changed between the scans
  for (std::size_t i = 0; i < measured.pixel_count(); ++i) {
    if (measured.begin()[i] != 0) shift += mean_1.begin()[i] - mean_2.begin()[i];
  }
  shift /= static_cast<double>(all.pixels);

  NoiseLine line{.at_half = all.variance};

  // Weights: squared Gaussian values have a variance proportional to their squared mean.
  for (int iteration = 0; iteration < 5; ++iteration) {
    double w = 0, wx = 0, wxx = 0, wy = 0, wxy = 0;
    for (std::size_t i = 0; i < measured.pixel_count(); ++i) {
      if (measured.begin()[i] == 0) continue;

      // x: grey level from half of full scale; y: sigma_w^2 from this pixel's two means alone.
      const double a = mean_1.begin()[i], b = mean_2.begin()[i];
      const double x = (a + b) / 2 - 127.5, y = steps / 2.0 * (a - b - shift) * (a - b - shift);

      const double predicted = std::max(line.at_half + line.gain * x, all.variance / 20);
      const double weight = 1 / (2 * predicted * predicted);

      w += weight;
      wx += weight * x;
      wxx += weight * x * x;
      wy += weight * y;
      wxy += weight * x * y;
    }

    // Equal grey levels give no slope.
    const double determinant = w * wxx - wx * wx;
    if (!(determinant > 1e-9 * w * wxx)) return {.at_half = all.variance};

    line = {.at_half = (wxx * wy - wx * wxy) / determinant,
            .gain = (w * wxy - wx * wy) / determinant,
            .gain_error = std::sqrt(w / determinant)};
  }

  return line;
}

NoiseEstimate noise_from_half_phase(const Image<double>& b_cos,
                                    const Image<std::uint8_t>& measured) {
  return scaled_variance(measured, 4, [&](std::size_t i) { return b_cos.begin()[i]; });
}

NoiseEstimate noise_from_half_phases(const Image<double>& b_cos_1, const Image<double>& b_cos_2,
                                     const Image<std::uint8_t>& measured) {
  return scaled_variance(measured, 2,
                         [&](std::size_t i) { return b_cos_1.begin()[i] - b_cos_2.begin()[i]; });
}

NoiseEstimate noise_from_modulations(const Image<double>& modulation_1,
                                     const Image<double>& modulation_2, int steps, double c1,
                                     const Image<std::uint8_t>& measured) {
  const double c2 = 1 - c1;
  // alpha_12 = 2 / alpha_p (B_1 / c_1 - B_2 / c_2); alpha_p cancels.
  const double factor = steps / 8.0 * (c1 * c1 * c2 * c2) / (c1 * c1 + c2 * c2) * 4;
  return scaled_variance(measured, factor, [&](std::size_t i) {
    return modulation_1.begin()[i] / c1 - modulation_2.begin()[i] / c2;
  });
}

bool mistakes_gamma_for_noise(const NoiseMeasurement& measurement) {
  return measurement.equation == "3.79" || measurement.equation == "3.99";
}

NoiseScan::NoiseScan(const Scan& scan) : strategy(scan.sequence.strategy) {
  const FrameViews frames = scan.frames;
  const double grey_level = frames.full_scale() / 255;

  const auto in_8_bits = [&](Image<double> image) {
    for (double& value : image) value /= grey_level;
    return image;
  };

  const Layout& layout = strategy.layout();
  const Band& band = layout.bands.front();
  const auto run = step_run(band);
  if (!run) throw Error(strategy.name() + ": measuring noise requires a run of phase steps");

  steps = run->steps;
  const PhaseDecoder decode(PhaseMethod::equation, {});
  const PhaseMaps maps = decode(frames, band);
  mean = in_8_bits(maps.mean);

  if (steps == 4 && !layout.cue) {
    b_cos = in_8_bits(weighted_sum(frames.part(run->first, 4), half_phase_weights()));
  }

  const Image<double> modulation = in_8_bits(maps.modulation);
  measured = unclipped_mask(frames);
  std::ranges::transform(measured, modulation, measured.begin(), [](std::uint8_t good, double B) {
    return static_cast<std::uint8_t>(good != 0 && B >= least_modulation ? 1 : 0);
  });

  if (order_source(layout) == OrderSource::neighbours && !layout.cue) {
    modulations[0] = modulation;
    modulations[1] = in_8_bits(decode(frames, layout.bands[1]).modulation);
  }
}

std::vector<NoiseMeasurement> calibrate_noise(std::span<const NoiseScan> scans) {
  NoiseMeasurement halves{{}, "3.82", "half phase channels of two scans"};
  NoiseMeasurement means{{}, "3.20", "means of two scans"};
  NoiseMeasurement unequal_means{{}, "3.19", "means of two scans with different step counts"};
  NoiseMeasurement modulations{{}, "3.99", "two modulations of one scan"};
  NoiseMeasurement half{{}, "3.79", "half phase channel of one scan"};

  // The sums of each measurement over all scans and pairs that allow it.
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const NoiseScan& a = scans[i];
    const Layout& layout = a.strategy.layout();

    if (!a.b_cos.empty()) add(half, noise_from_half_phase(a.b_cos, a.measured));
    if (!a.modulations[1].empty()) {
      add(modulations, noise_from_modulations(a.modulations[0], a.modulations[1], a.steps,
                                              layout.bands[0].share, a.measured));
    }

    for (const NoiseScan& b : scans.subspan(i + 1)) {
      const bool alike = a.strategy == b.strategy;
      if (!alike && !(of_one_band(layout) && of_one_band(b.strategy.layout()))) continue;
      throw_if(alike && std::ranges::equal(a.mean, b.mean),  // noise would make them differ
               "two of the scans have identical frames: copies, or virtual scans with the same "
               "`seed`; measuring noise requires two takes");

      const Image<std::uint8_t> both = in_both(a.measured, b.measured);
      add(alike ? means : unequal_means, noise_from_means(a.mean, a.steps, b.mean, b.steps, both));
      if (alike && !a.b_cos.empty()) add(halves, noise_from_half_phases(a.b_cos, b.b_cos, both));
    }
  }

  // Sums to means, most trusted first.
  std::vector<NoiseMeasurement> all;
  for (NoiseMeasurement mean : {halves, means, unequal_means, modulations, half}) {
    if (mean.count == 0) continue;
    mean.variance /= mean.count;
    mean.standard_error = std::sqrt(mean.standard_error) / mean.count;
    all.push_back(mean);
  }

  throw_if(all.empty(),
           "these scans cannot measure noise; expected two equal scans of a static scene, one of 4 "
           "steps of one frequency, or one with a second band in the same frames");

  for (NoiseMeasurement& other : all) other.reason = disagreement(other, all.front());
  return all;
}

std::optional<NoiseLine> noise_line(std::span<const NoiseScan> scans) {
  NoiseLine sum;
  int pairs = 0;

  for (std::size_t i = 0; i < scans.size(); ++i) {
    for (const NoiseScan& b : scans.subspan(i + 1)) {
      const NoiseScan& a = scans[i];
      if (!(a.strategy == b.strategy)) continue;

      const NoiseLine line =
          noise_line_from_means(a.mean, b.mean, a.steps, in_both(a.measured, b.measured));
      sum.at_half += line.at_half;
      sum.gain += line.gain;
      sum.gain_error = std::hypot(sum.gain_error, line.gain_error);
      ++pairs;
    }
  }

  if (pairs == 0 || !(sum.gain > 4 * sum.gain_error)) return std::nullopt;
  return NoiseLine{sum.at_half / pairs, sum.gain / pairs, sum.gain_error / pairs};
}

}  // namespace slipstream
