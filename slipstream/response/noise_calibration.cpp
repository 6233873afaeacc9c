#include "slipstream/response/noise_calibration.h"

#include <algorithm>
#include <cmath>

#include "slipstream/base/error.h"
#include "slipstream/decode/phase_decoder.h"

namespace slipstream {
namespace {

constexpr double least_modulation = 8;  // grey levels

/// Estimates of one kind, put together.
class Estimates {
 public:
  Estimates(const char* equation, const char* method) : equation_(equation), method_(method) {}

  void add(const NoiseEstimate& estimate) {
    variance_ += estimate.variance;
    square_error_ += estimate.standard_error * estimate.standard_error;
    pixels_ = estimate.pixels;
    ++count_;
  }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] NoiseMeasurement mean() const {
    return {.equation = equation_,
            .method = method_,
            .variance = variance_ / count_,
            .standard_error = std::sqrt(square_error_) / count_,
            .count = count_,
            .pixels = pixels_};
  }

 private:
  const char* equation_;
  const char* method_;
  double variance_ = 0, square_error_ = 0;
  std::size_t pixels_ = 0;
  int count_ = 0;
};

Image<std::uint8_t> in_both(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  if (a.size() != b.size()) {
    throw Error("the scans are of different sizes; they are to be of one unmoved scene");
  }
  Image<std::uint8_t> both = a;
  std::transform(both.begin(), both.end(), b.begin(), both.begin(),
                 [](std::uint8_t x, std::uint8_t y) { return static_cast<std::uint8_t>(x & y); });
  return both;
}

bool of_one_band(const Layout& layout) {
  return layout.bands.size() == 1 && !layout.cue;
}

/// What noise would have made different is not.
void require_two_takes(const Image<double>& a, const Image<double>& b) {
  if (!std::equal(a.begin(), a.end(), b.begin(), b.end())) return;
  throw Error(
      "two of the scans have the very same frames, noise and all: copies, or the virtual scanner's "
      "of one --seed; noise is measured between two takes");
}

/// Why a measurement says another value than the one trusted most; empty where it does not.
std::string disagreement(const NoiseMeasurement& other, const NoiseMeasurement& trusted) {
  const double difference = other.variance - trusted.variance;
  const double error = std::hypot(other.standard_error, trusted.standard_error);
  if (std::abs(difference) < std::max(4 * error, 0.05 * trusted.variance)) return "";
  if (mistakes_gamma_for_noise(other) || other.equation == "3.19") {
    return "the response is not linear, and this counts what it leaves as noise: calibrate gamma";
  }
  return "light or scene changed between the scans in a way that is not the same everywhere";
}

}  // namespace

bool mistakes_gamma_for_noise(const NoiseMeasurement& measurement) {
  return measurement.equation == "3.79" || measurement.equation == "3.99";
}

NoiseScan::NoiseScan(const Scan& scan) : strategy_(scan.sequence.strategy) {
  const FrameViews frames = scan.frames;
  const double grey_level = frames.full_scale() / 255;
  const auto in_8_bits = [&](Image<double> image) {
    for (double& value : image) value /= grey_level;
    return image;
  };
  const Layout& layout = strategy_.layout();
  const Band& band = layout.bands.front();
  const auto run = step_run(band);
  if (!run)
    throw Error(strategy_.name() + ": no run of phase steps in it, by which noise is measured");
  steps_ = run->steps;
  const PhaseDecoder decode(PhaseMethod::equation, {});
  const PhaseMaps maps = decode(frames, band);
  mean_ = in_8_bits(maps.mean);
  if (steps_ == 4 && !layout.cue) {
    b_cos_ = in_8_bits(weighted_sum(frames.part(run->first, 4), half_phase_weights()));
  }
  const Image<double> modulation = in_8_bits(maps.modulation);
  measured_ = unclipped_mask(frames);
  std::transform(measured_.begin(), measured_.end(), modulation.begin(), measured_.begin(),
                 [](std::uint8_t good, double B) {
                   return static_cast<std::uint8_t>(good != 0 && B >= least_modulation ? 1 : 0);
                 });
  if (layout.unwrapping == Unwrapping::vote && !layout.cue) {
    modulations_[0] = modulation;
    modulations_[1] = in_8_bits(decode(frames, layout.bands[1]).modulation);
  }
}

std::vector<NoiseMeasurement> calibrate_noise(std::span<const NoiseScan> scans) {
  Estimates halves("3.82", "half phase channels of two scans");
  Estimates means("3.20", "means of two scans");
  Estimates unequal_means("3.19", "means of two scans of other step counts");
  Estimates modulations("3.99", "two modulations of one scan");
  Estimates half("3.79", "half phase channel of one scan");
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const NoiseScan& a = scans[i];
    const Layout& layout = a.strategy_.layout();
    if (!a.b_cos_.empty()) half.add(noise_from_half_phase(a.b_cos_, a.measured_));
    if (!a.modulations_[1].empty()) {
      modulations.add(noise_from_modulations(a.modulations_[0], a.modulations_[1], a.steps_,
                                             layout.bands[0].share, a.measured_));
    }
    for (const NoiseScan& b : scans.subspan(i + 1)) {
      const bool alike = a.strategy_ == b.strategy_;
      if (!alike && !(of_one_band(layout) && of_one_band(b.strategy_.layout()))) continue;
      if (alike) require_two_takes(a.mean_, b.mean_);
      const Image<std::uint8_t> both = in_both(a.measured_, b.measured_);
      (alike ? means : unequal_means)
          .add(noise_from_means(a.mean_, a.steps_, b.mean_, b.steps_, both));
      if (alike && !a.b_cos_.empty()) halves.add(noise_from_half_phases(a.b_cos_, b.b_cos_, both));
    }
  }
  std::vector<NoiseMeasurement> all;
  for (const Estimates* estimates : {&halves, &means, &unequal_means, &modulations, &half}) {
    if (!estimates->empty()) all.push_back(estimates->mean());
  }
  if (all.empty()) {
    throw Error(
        "these scans measure no noise; give two alike of one unmoved scene, one of 4 steps of one "
        "frequency, or one of a second band in the same frames");
  }
  for (NoiseMeasurement& other : all) other.reason = disagreement(other, all.front());
  return all;
}

std::optional<NoiseLine> noise_line(std::span<const NoiseScan> scans) {
  NoiseLine sum;
  int pairs = 0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    for (const NoiseScan& b : scans.subspan(i + 1)) {
      const NoiseScan& a = scans[i];
      if (!(a.strategy_ == b.strategy_)) continue;
      const NoiseLine line =
          noise_line_from_means(a.mean_, b.mean_, a.steps_, in_both(a.measured_, b.measured_));
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
