// Turns of a band from the sums of its frames, corrected for the projector's response.
#include "reconstruct/fused/band_stage.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <numbers>
#include <optional>
#include <vector>

#include "base/numbers.h"
#include "decode/equations.h"
#include "decode/phase_decoder.h"
#include "geometry/stripe_geometry.h"
#include "reconstruct/fused/fused_stages.h"
#include "reconstruct/fused/sinusoid_rows.h"

namespace slipstream {
namespace {

constexpr double largest_error = 8e-7;  // rad
constexpr int nodes = 48;

using Values = Eigen::Matrix<double, nodes, 1>;

/// Correction at a phase, wrapped to (-pi, pi].
double added(const PhaseCorrection& correction, double phi) {
  const double measured = phi - two_pi * std::floor(phi / two_pi);
  return std::remainder(corrected_phase(correction, measured) - measured, two_pi);
}

/// The folded circle of N frames.
struct Fold {
  double end;      ///< T, rad
  double tangent;  ///< of T

  static std::optional<Fold> of(int steps) {
    if (steps == 3 || steps == 6) return Fold{std::numbers::pi / 3, std::numbers::sqrt3};
    if (steps == 4) return Fold{std::numbers::pi / 4, 1};
    return std::nullopt;
  }

  /// Phase at x, rad.
  [[nodiscard]] double phase(double b, double x) const {
    return std::atan2(tangent * (1 - x), 2 + b + b * x);
  }
};

bool is_odd(const PhaseCorrection& correction) {
  constexpr int samples = 500;
  for (int i = 0; i < samples; ++i) {
    const double phi = two_pi * i / (samples * correction.steps);
    if (std::abs(added(correction, phi) + added(correction, -phi)) > largest_error) return false;
  }

  return true;
}

/// Chebyshev coefficients of the corrected phase, rad.
Values spectrum(const PhaseCorrection& correction, const Fold& fold, double b) {
  static const auto transform = chebyshev_transform<nodes>();

  Values values;
  for (int i = 0; i < nodes; ++i) {
    const double phi = fold.phase(b, std::cos(std::numbers::pi * (i + 0.5) / nodes));
    values(i) = phi + added(correction, phi);
  }

  return transform * values;
}

/// Least degree with a truncation error within the limit.
int degree_of(const Values& spectrum) {
  double left_out = 0;
  for (int k = nodes - 1; k > 0; --k) {
    // A fifth of the error remains for rounding.
    left_out += std::abs(spectrum(k));
    if (left_out > 0.8 * largest_error) return k;
  }

  return 0;
}

std::vector<float> in_turns(const Values& spectrum, int degree) {
  constexpr int terms = FoldedPhase::largest_degree + 1;
  Eigen::Matrix<double, terms, 1> kept = spectrum.head<terms>();
  kept.tail(terms - 1 - degree).setZero();

  // From Chebyshev coefficients to powers of x.
  const Eigen::Matrix<double, terms, 1> powers = chebyshev_coefficients<terms>().transpose() * kept;
  std::vector<float> coefficients;
  for (int k = degree; k >= 0; --k) coefficients.push_back(static_cast<float>(powers(k) / two_pi));
  return coefficients;
}

/// Whether the polynomial matches the correction, and the correction stays within [0, T].
bool holds(const FoldedPhase& folded, const PhaseCorrection& correction, const Fold& fold) {
  constexpr int samples = 1000;
  for (int i = 0; i <= samples; ++i) {
    const double x = 2.0 * i / samples - 1, phi = fold.phase(folded.b, x);
    const double corrected = phi + added(correction, phi);

    double sum = 0;
    for (const float c : folded.coefficients) sum = sum * x + c;

    const bool close = std::abs(two_pi * sum - corrected) <= largest_error;
    const bool inside = corrected >= -largest_error && corrected <= fold.end + largest_error;
    if (!close || !inside) return false;
  }

  return true;
}

/// Correction in turns at the part r of a period, linear between the entries.
double added_turns(const PhaseCorrection& correction, double r) {
  const auto count = static_cast<double>(correction.added.size());
  const double place = (r - std::floor(r)) * count;
  const double floor = std::floor(place);

  const auto entry = [&](double i) {
    return correction.added[static_cast<std::size_t>(i) % correction.added.size()];
  };

  return std::lerp(entry(floor), entry(floor + 1), place - floor) / two_pi;
}

/// The correction as an odd polynomial; empty if its error would exceed 8e-7 rad.
std::vector<float> wave_of(const PhaseCorrection& correction) {
  constexpr double most_turns = largest_error / two_pi;
  constexpr int places = 128;
  constexpr int degree = 2 * SinusoidStage::wave_terms - 1;

  // 1. The odd Chebyshev terms of the correction in x = 2 r, over half a period on either side of
  // its zero.
  const auto T = chebyshev_coefficients<degree + 1>();
  Eigen::Matrix<double, 1, degree + 1> sum = Eigen::Matrix<double, 1, degree + 1>::Zero();
  for (int k = 1; k <= degree; k += 2) {
    double projection = 0;
    for (int i = 0; i < places; ++i) {
      const double angle = std::numbers::pi * (i + 0.5) / places;
      projection +=
          2.0 / places * added_turns(correction, std::cos(angle) / 2) * std::cos(k * angle);
    }

    sum += projection * T.row(k);
  }

  // 2. As powers of r = x / 2, the highest first.
  std::vector<float> wave;
  for (int power = degree; power > 0; power -= 2) {
    wave.push_back(static_cast<float>(sum(power) * std::exp2(power)));
  }

  // 3. Check the error; the correction may be too steep for this degree.
  constexpr int samples = 1000;
  for (int i = 0; i <= samples; ++i) {
    const double r = static_cast<double>(i) / samples - 0.5;

    double slope = 0;
    for (const float c : wave) slope = slope * r * r + c;

    if (!(std::abs(slope * r - added_turns(correction, r)) <= most_turns)) return {};
  }

  return wave;
}

/// Appends the table's `periods`, N of a run of steps, and the first entry again for a turn of 1.
void add_correction(SinusoidStage& stage, const PhaseCorrections& corrections, int periods) {
  const auto found = corrections.find(periods);
  if (found == corrections.end()) return;

  const PhaseCorrection& correction = found->second;

  // The folded phase and the wave have the period of the harmonics, 1 / N of a turn.
  if (periods == stage.steps) {
    stage.folded = folded_phase(correction);
    stage.correction_wave = wave_of(correction);
  }
  if (!stage.correction_wave.empty()) return;

  // Otherwise a table around the whole circle.
  const std::size_t count = correction.added.size();
  const std::size_t segments = count * static_cast<std::size_t>(periods);
  const auto turns_at = [&](std::size_t i) { return correction.added[i % count] / two_pi; };

  stage.segments = static_cast<float>(segments);
  for (std::size_t i = 0; i <= segments; ++i) {
    stage.correction.push_back(static_cast<float>(turns_at(i)));
    stage.correction_rise.push_back(static_cast<float>(turns_at(i + 1) - turns_at(i)));
  }
}

/// Stage of N phase-shifted frames.
SinusoidStage stepped_stage(int steps, const PhaseCorrections& corrections) {
  SinusoidStage stage{SinusoidNumbers{.steps = steps}};
  add_correction(stage, corrections, steps);

  const auto weigh = [&](double sine_square, double divisor) {
    stage.sine_weight = static_cast<float>(std::sqrt(sine_square));
    stage.sine_square = static_cast<float>(sine_square);
    stage.modulation_scale = static_cast<float>(1 / divisor);
  };

  if (const ClosedForm* form = closed_form(steps)) {
    weigh(form->sine_square, form->divisor);
  } else if (steps == 5) {
    weigh((5 + std::sqrt(5)) / 2, 10);  // (2 sin(2 pi / 5))^2
  } else {
    const Band channel = phase_shifted_band(steps, 0, steps, 1);
    stage.cosines = channel.cosine;
    stage.sines = channel.sine;
  }

  return stage;
}

/// Largest common unit of all weights if sums over 16-bit frames are then exact in float, else 0.
double common_unit(const std::vector<double>& weights) {
  constexpr double rounding = 1e-9, largest_sum = 256;

  double largest = 0;
  for (const double weight : weights) largest = std::max(largest, std::abs(weight));

  // Try a whole number for the largest weight; the others must then be whole as well.
  for (double times = 1; times < largest_sum; ++times) {
    const double unit = largest / times;

    double sum = 0;
    const bool whole = std::all_of(weights.begin(), weights.end(), [&](double weight) {
      sum += std::abs(weight / unit);
      return std::abs(weight / unit - std::round(weight / unit)) < rounding;
    });

    if (whole) return sum < largest_sum + 0.5 ? unit : 0;
  }

  return 0;
}

/// Converts weights to whole numbers, with a factor per sum, as in the closed forms.
void make_whole(SinusoidStage& stage) {
  const double cosine_unit = common_unit(stage.cosines), sine_unit = common_unit(stage.sines);
  if (!(cosine_unit > 0 && sine_unit > 0)) return;

  for (double& weight : stage.cosines) weight = std::round(weight / cosine_unit);
  for (double& weight : stage.sines) weight = std::round(weight / sine_unit);

  for (std::size_t n = 0; n < stage.cosines.size(); ++n) {
    stage.whole.push_back(
        {static_cast<float>(stage.cosines[n]), static_cast<float>(stage.sines[n]), stage.means[n]});
  }

  // The units go into the factors that follow the sums.
  const double sine_weight = sine_unit / cosine_unit;
  stage.sine_weight = static_cast<float>(sine_weight);
  stage.sine_square = static_cast<float>(sine_weight * sine_weight);
  stage.modulation_scale = static_cast<float>(cosine_unit);
}

/// Stage with any weights, of the frames from the first to the last with a weight.
FusedStages::BandStage weighted_stage(const Band& band) {
  const auto counts = [&](std::ptrdiff_t n) {
    const auto i = static_cast<std::size_t>(n);
    return band.cosine[i] != 0 || band.sine[i] != 0 || band.mean[i] != 0;
  };

  // Leave out frames without a weight at either end.
  std::ptrdiff_t first = 0, end = std::ssize(band.mean);
  while (!counts(first)) ++first;
  while (!counts(end - 1)) --end;

  const auto part = [&](const std::vector<double>& weights) {
    return std::vector<double>(weights.begin() + first, weights.begin() + end);
  };

  const int steps = band.cycle ? band.cycle->steps : static_cast<int>(end - first);
  FusedStages::BandStage stage{.sinusoid = {SinusoidNumbers{.steps = steps}},
                               .first_frame = static_cast<int>(first)};
  stage.sinusoid.cosines = part(band.cosine);
  stage.sinusoid.sines = part(band.sine);
  for (const double weight : part(band.mean)) {
    stage.sinusoid.means.push_back(static_cast<float>(steps * weight));
  }

  make_whole(stage.sinusoid);
  return stage;
}

/// Stage of a window longer than a cycle of steps, weighted for the phase of steps without shifts.
FusedStages::BandStage window_stage(Band band, const PhaseCorrections& corrections) {
  const Shifts shifts = band.cycle->shifts;

  // Turn the weights by the shifts' origin, so that one correction serves any shifts.
  for (std::size_t n = 0; n < band.cosine.size(); ++n) {
    const auto turned = std::complex(band.cosine[n], band.sine[n]) * std::polar(1.0, shifts.origin);
    band.cosine[n] = turned.real();
    band.sine[n] = shifts.backwards ? -turned.imag() : turned.imag();
  }

  FusedStages::BandStage stage = weighted_stage(band);
  add_correction(stage.sinusoid, corrections, stage.sinusoid.steps);
  return stage;
}

}  // namespace

FoldedPhase folded_phase(const PhaseCorrection& correction) {
  const std::optional<Fold> fold = Fold::of(correction.steps);
  if (!fold || !is_odd(correction)) return {};

  FoldedPhase best;
  int least = FoldedPhase::largest_degree + 1;

  // Try 1 + b from 1/8 to 64, and keep the one of least degree.
  constexpr double octaves = 0.25;
  for (int i = -12; i <= 24; ++i) {
    // In float, as in the kernels.
    const auto b = static_cast<float>(std::exp2(octaves * i) - 1);

    const Values terms = spectrum(correction, *fold, b);
    const int needed = degree_of(terms);
    if (needed >= least) continue;

    const FoldedPhase folded{b, in_turns(terms, needed)};
    if (!holds(folded, correction, *fold)) continue;
    least = needed;
    best = folded;
  }

  return best;
}

FusedStages::BandStage band_stage(const Band& band, const PhaseCorrections& corrections) {
  const auto run = bent_run(band);

  FusedStages::BandStage stage =
      band.cycle ? window_stage(band, corrections)
      : run      ? FusedStages::BandStage{.sinusoid = stepped_stage(run->steps, corrections),
                                          .first_frame = run->first}
                 : weighted_stage(band);

  stage.periods = band.periods;
  if (!run) add_correction(stage.sinusoid, corrections, 1);

  // Runs with shifted steps are decoded as if unshifted, and the turn is put right afterwards.
  if (!run || run->shifts == Shifts{}) return stage;
  stage.sinusoid.direction = run->shifts.backwards ? -1 : 1;
  stage.sinusoid.offset = static_cast<float>(-run->shifts.origin / two_pi);
  return stage;
}

}  // namespace slipstream
