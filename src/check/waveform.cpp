#include "check/waveform.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/linear_algebra.h"
#include "base/numbers.h"

namespace slipstream {
namespace {

constexpr int first_harmonic = 2;
/// A cosine and a sine for each harmonic.
constexpr int unknowns = 2 * (Waveform::most_harmonic - first_harmonic + 1);

/// The part of each harmonic in a pixel's frames that the patterns do not explain.
class HarmonicParts {
 public:
  HarmonicParts(const FrameModel& model, std::vector<StepRun> runs)
      : model_(model), runs_(std::move(runs)) {}

  /// Rows: the unexplained components; columns: for each harmonic a cosine and a sine.
  [[nodiscard]] Eigen::MatrixXd of(const SampleReading& reading) const {
    Eigen::MatrixXd frames = Eigen::MatrixXd::Zero(model_.layout().frames, unknowns);

    for (std::size_t b = 0; b < runs_.size(); ++b) {
      const StepRun& run = runs_[b];
      const double turned = shifted_phase(run.shifts, reading.phase[b]);

      for (int n = 0; n < run.steps; ++n) {
        const double a = turned - two_pi * n / run.steps;
        for (int i = 0; i < unknowns; i += 2) {
          const int k = first_harmonic + i / 2;
          frames(run.first + n, i) = reading.modulation[b] * std::cos(k * a);
          frames(run.first + n, i + 1) = reading.modulation[b] * std::sin(k * a);
        }
      }
    }

    return model_.unexplained_of(frames);
  }

 private:
  const FrameModel& model_;
  std::vector<StepRun> runs_;  ///< of each band
};

/// The k-th harmonic of ((1 + cos a) / 2)^gamma over its first.
double harmonic_of_power(double gamma, int k) {
  double harmonic = 1;
  for (int j = 1; j < k; ++j) harmonic *= (gamma - j) / (gamma + 1 + j);
  return harmonic;
}

/// Harmonic k of a square wave, blurred by a Gaussian so that its third harmonic is the given one.
double harmonic_of_stripes(double third, int k) {
  if (k % 2 == 0) return 0;
  const double sharpness = std::min(1.0, 3 * third);
  return std::pow(sharpness, (k * k - 1) / 8.0) / k;
}

/// RMS error of the phase of N steps, in which harmonics N - 1 and N + 1 look like the first.
double phase_error(const Waveform& waveform, int steps) {
  const double second = std::min(0.9, std::abs(waveform.harmonics[2]));
  const double third = std::abs(waveform.harmonics[3]);
  const double gamma = (1 + 2 * second) / (1 - second);

  double square = 0;
  for (const int k : {steps - 1, steps + 1}) {
    square += std::pow(harmonic_of_power(gamma, k), 2) / 2;
    square += std::pow(harmonic_of_stripes(third, k), 2) / 2;
  }

  return std::sqrt(square);
}

/// The runs of the bands; empty unless all are plain steps, four or more in the measuring one.
std::vector<StepRun> runs_of(const FrameModel& model) {
  std::vector<StepRun> runs;
  for (const Band& band : model.layout().bands) {
    const auto run = step_run(band);
    if (!run || band.carrier > 0) return {};
    runs.push_back(*run);
  }

  constexpr int fewest = 4;
  if (runs[model.measuring_band()].steps < fewest) runs.clear();
  return runs;
}

}  // namespace

bool Waveform::explains(double residual_without) const {
  // Right scans leave up to a quarter: real stripes of one bit, whose blur differs with depth.
  constexpr double most_left = 0.35, most_lopsided = 0.02, most_lopsided_share = 0.1;

  const bool is_even = std::ranges::all_of(harmonics, [](const std::complex<double>& harmonic) {
    return std::abs(harmonic.imag()) <=
           most_lopsided + most_lopsided_share * std::abs(harmonic.real());
  });
  return is_even && residual <= most_left * residual_without;
}

bool can_show_waveform(const FrameModel& model) {
  return !runs_of(model).empty();
}

std::optional<Waveform> waveform_of(const FrameModel& model, const JudgedScan& scan,
                                    const FrameOrder& order) {
  // 1. The runs of the bands.
  std::vector<StepRun> runs = runs_of(model);
  if (runs.empty() || scan.settings.moving || scan.samples.groups() == 0) return std::nullopt;
  const int steps = runs[model.measuring_band()].steps;

  // 2. Normal equations. Both factors of each product come from neighbours, which share no noise.
  const HarmonicParts parts(model, std::move(runs));
  using Normal = Eigen::Matrix<double, unknowns, unknowns>;
  using Column = Eigen::Vector<double, unknowns>;
  Normal normal = Normal::Zero();
  Column right = Column::Zero();
  double all = 0, variation = 0;

  SampleReading here, next;
  const auto rows = static_cast<Eigen::Index>(model.unexplained_count());
  for (std::size_t g = 0; g < scan.samples.groups(); ++g) {
    const float* const levels = scan.samples.levels(g, ScanSamples::middle);
    model.read(levels, order, here);
    const Eigen::MatrixXd parts_here = parts.of(here);
    const Eigen::Map<const Eigen::VectorXd> left_here(here.unexplained.data(), rows);

    for (const auto place : {ScanSamples::right, ScanSamples::below}) {
      if (!scan.samples.lit(g, place)) continue;

      model.read(scan.samples.levels(g, place), order, next);
      const Eigen::MatrixXd parts_next = parts.of(next);
      const Eigen::Map<const Eigen::VectorXd> left_next(next.unexplained.data(), rows);

      normal += parts_here.transpose() * parts_next + parts_next.transpose() * parts_here;
      right += parts_here.transpose() * left_next + parts_next.transpose() * left_here;
      all += 2 * left_here.dot(left_next);
      variation += 2 * scan.samples.variation(levels);
    }
  }

  if (!(variation > 0)) return std::nullopt;

  // 3. Harmonics that these steps cannot show have empty columns: the ridge makes them 0.
  normal.diagonal().array() += 1e-6 * normal.trace() + 1e-12;
  const Column found = solve_symmetric(normal, right);

  Waveform waveform;
  for (int i = 0; i < unknowns; i += 2) {
    waveform.harmonics[first_harmonic + i / 2] = {found[i], -found[i + 1]};
  }

  // 4. The residual.
  const double left = all - found.dot(2 * right - normal * found);
  waveform.residual = std::sqrt(std::max(0.0, left / variation));
  waveform.phase_error = phase_error(waveform, steps);
  return waveform;
}

std::optional<double> phase_error_left(const FrameViews& frames, const Sequence& sequence,
                                       const PhotometricCalibration& photometry,
                                       double least_modulation) {
  // Frames computed from one picture have no waveform of their own.
  if (sequence.strategy.is_spectral()) return std::nullopt;

  const FrameModel model(sequence, photometry);
  const CheckSettings settings{.minimum_modulation = least_modulation,
                               .moving = measuring_band(model.layout()).cycle.has_value()};
  ScanSamples samples(frames.size(), frames.count());
  samples.take(frames, {.least_range = least_range(settings)});

  const auto waveform = waveform_of(
      model, {model, samples, sequence, nullptr, photometry, settings}, model.identity());
  return waveform ? std::optional(waveform->phase_error) : std::nullopt;
}

}  // namespace slipstream
