#include "decode/phase_decoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <type_traits>
#include <vector>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "decode/equations.h"

namespace slipstream {
namespace {

using std::numbers::pi;

int largest_sum(const std::array<int, 6>& weights) {
  int positive = 0;
  for (const int weight : weights) positive += std::max(weight, 0);
  return 255 * positive;
}

/// Visits the pixels; `sample` converts the N intensities of one to a PhaseSample.
template <class Number, class Pixel, class Sample>
PhaseMaps decode_pixels(const Frames<Pixel>& frames, const Sample& sample) {
  const Size size = frames.front().size();
  PhaseMaps maps{Image<double>(size), Image<double>(size), Image<double>(size)};

  for_each_row(size.height, [&](int row) {
    std::vector<Number> intensities(frames.size());
    for (int column = 0; column < size.width; ++column) {
      for (std::size_t n = 0; n < frames.size(); ++n) {
        intensities[n] = static_cast<Number>(frames[n](column, row));
      }

      const PhaseSample pixel = sample(std::span<const Number>(intensities));
      maps.mean(column, row) = pixel.mean;
      maps.modulation(column, row) = pixel.modulation;
      maps.wrapped_phase(column, row) = pixel.wrapped_phase;
    }
  });

  return maps;
}

template <class Number>
double mean_of(std::span<const Number> I) {
  Number sum = 0;
  for (const Number intensity : I) sum += intensity;
  return static_cast<double>(sum) / static_cast<double>(I.size());  // (1.3)
}

/// Combines the two sinusoids of a band with a carrier: see Band::carrier.
void demodulate(PhaseMaps& maps, const PhaseMaps& mirrored) {
  std::ranges::transform(maps.modulation, mirrored.modulation, maps.modulation.begin(),
                         [](double a, double b) { return std::min(a, b); });
  std::ranges::transform(maps.wrapped_phase, mirrored.wrapped_phase, maps.wrapped_phase.begin(),
                         wrapped_sum);
}

constexpr std::array<ClosedForm, 3> closed_forms{{
    {.steps = 3, .u = {2, -1, -1}, .v = {0, 1, -1}, .divisor = 3, .sine_square = 3},
    {.steps = 4, .u = {1, 0, -1, 0}, .v = {0, 1, 0, -1}, .divisor = 2, .sine_square = 1},
    {.steps = 6,
     .u = {2, 1, -1, -2, -1, 1},
     .v = {0, 1, 1, 0, -1, -1},
     .divisor = 6,
     .sine_square = 3},
}};

}  // namespace

void require_valid(const PhaseCorrection& correction, int steps) {
  throw_if(
      correction.steps != steps || steps < 1 || steps == 2,
      "the phase correction of {} steps is given for {}; both must be the same N, 1, 3 or more",
      correction.steps, steps);

  const bool finite =
      std::ranges::all_of(correction.added, [](double added) { return std::isfinite(added); });
  throw_if(correction.added.empty() || !finite,
           "the phase correction of {} steps is empty or not finite", steps);
}

double corrected_phase(const PhaseCorrection& correction, double phi) {
  // The table holds one period of N over the circle and repeats.
  const std::size_t count = correction.added.size();
  const double place = phi * correction.steps / two_pi * static_cast<double>(count);
  const double floor = std::floor(place);
  const std::size_t left = static_cast<std::size_t>(floor) % count;
  const std::size_t right = (left + 1) % count;

  const double added = std::lerp(correction.added[left], correction.added[right], place - floor);
  const double corrected = phi + added;
  if (corrected < 0) return std::min(corrected + two_pi, std::nextafter(two_pi, 0));
  return corrected < two_pi ? corrected : corrected - two_pi;
}

PhaseTables::PhaseTables(int steps, const PhaseCorrection* correction) : form_(closed_form(steps)) {
  throw_if(form_ == nullptr, "no phase table for {} steps; expected 3, 4 or 6", steps);

  largest_U_ = largest_sum(form_->u);
  largest_V_ = largest_sum(form_->v);

  const std::size_t rows = static_cast<std::size_t>(2 * largest_V_ + 1);
  const std::size_t columns = static_cast<std::size_t>(2 * largest_U_ + 1);
  mlut_.resize(rows * columns);
  plut_.resize(rows * columns);

  for_each_row(static_cast<int>(rows), [&](int row) {
    const int V = row - largest_V_;
    for (int U = -largest_U_; U <= largest_U_; ++U) {
      mlut_[position(U, V)] = form_->modulation(U, V);
      const double phi = form_->wrapped_phase(U, V);
      plut_[position(U, V)] = correction == nullptr ? phi : corrected_phase(*correction, phi);
    }
  });
}

IntensityRatio::IntensityRatio() {
  for (int i = 0; i <= segments; ++i) {
    const double ratio = static_cast<double>(i) / segments;
    angle_[i] = std::atan2(std::numbers::sqrt3 * ratio, 2 - ratio);
  }
}

double IntensityRatio::wrapped_phase(std::span<const double> I) const {
  constexpr double sixth = pi / 3;
  const auto [least, greatest] = std::minmax({I[0], I[1], I[2]});
  if (!(greatest > least)) return 0;

  // The angle within a sixth of the circle, from the table.
  const double middle = I[0] + I[1] + I[2] - least - greatest;
  const double place = (middle - least) / (greatest - least) * segments;
  const auto left = static_cast<std::size_t>(std::clamp(place, 0.0, segments - 1.0));
  const double within =
      std::lerp(angle_[left], angle_[left + 1], place - static_cast<double>(left));

  // From the greatest at n = 0, the ratio rises while I[1] catches up, then falls.
  const bool first = I[0] == greatest, second = !first && I[1] == greatest;
  if (first) return I[1] >= I[2] ? within : within == 0 ? 0 : 6 * sixth - within;
  if (second) return I[0] >= I[2] ? 2 * sixth - within : 2 * sixth + within;
  return I[1] >= I[0] ? 4 * sixth - within : 4 * sixth + within;
}

PhaseDecoder::PhaseDecoder(PhaseMethod method, const std::vector<int>& steps,
                           PhaseCorrections corrections)
    : method_(method), corrections_(std::move(corrections)) {
  for (const auto& [N, correction] : corrections_) require_valid(correction, N);

  if (method_ != PhaseMethod::tables) return;
  for (const int N : steps) {
    if (closed_form(N) != nullptr) tables_.try_emplace(N, N, correction_for(N));
  }
}

const PhaseCorrection* PhaseDecoder::correction_for(int steps) const {
  const auto found = corrections_.find(steps);
  return found == corrections_.end() ? nullptr : &found->second;
}

PhaseMethod PhaseDecoder::method_for(int steps, const FrameViews& frames) const {
  const bool is_of_bytes = frames.visit(
      []<class Pixel>(const Frames<Pixel>&) { return std::is_same_v<Pixel, std::uint8_t>; });

  const bool is_possible = method_ == PhaseMethod::closed_form ? closed_form(steps) != nullptr
                           : method_ == PhaseMethod::tables ? tables_.contains(steps) && is_of_bytes
                                                            : steps == 3;

  return is_possible ? method_ : PhaseMethod::equation;
}

PhaseMethod PhaseDecoder::method_for(const Band& band, const FrameViews& frames) const {
  const auto run = step_run(band);
  return run ? method_for(run->steps, frames) : PhaseMethod::equation;
}

PhaseMaps PhaseDecoder::operator()(const FrameViews& frames, int first, int steps) const {
  const PhaseMethod method = method_for(steps, frames);
  return frames.part(first, steps).visit([&]<class Pixel>(const Frames<Pixel>& views) {
    // The tables contain corrected phases.
    if constexpr (std::is_same_v<Pixel, std::uint8_t>) {
      if (method == PhaseMethod::tables) {
        const PhaseTables& tables = tables_.at(steps);
        return decode_pixels<int>(views, [&](std::span<const int> I) -> PhaseSample {
          const auto [U, V] = table_index<int>(tables.form(), I);
          return {mean_of(I), tables.mlut(U, V), tables.plut(U, V)};
        });
      }
    }

    // All other methods correct each pixel's phase afterwards.
    const PhaseCorrection* const correction = correction_for(steps);
    const auto decode = [&](const auto& sample) {
      return decode_pixels<double>(views, [&](std::span<const double> I) {
        PhaseSample pixel = sample(I);
        double& phi = pixel.wrapped_phase;
        if (correction != nullptr) phi = corrected_phase(*correction, phi);
        return pixel;
      });
    };

    if (method == PhaseMethod::closed_form) {
      return decode([form = *closed_form(steps)](std::span<const double> I) -> PhaseSample {
        const auto [U, V] = table_index<double>(form, I);
        return {mean_of(I), form.modulation(U, V), form.wrapped_phase(U, V)};
      });
    }

    const PhaseEquations equations(steps);
    if (method == PhaseMethod::equation) return decode(equations);

    // The ratio of intensities gives the phase only.
    return decode([&, ratio = IntensityRatio()](std::span<const double> I) {
      PhaseSample pixel = equations(I);
      pixel.wrapped_phase = ratio.wrapped_phase(I);
      return pixel;
    });
  });
}

PhaseMaps PhaseDecoder::operator()(const FrameViews& frames, const Band& band) const {
  PhaseMaps maps = sinusoid(frames, band);
  for (const Band& mirrored : band.mirrored) demodulate(maps, sinusoid(frames, mirrored));
  return maps;
}

PhaseMaps PhaseDecoder::sinusoid(const FrameViews& frames, const Band& band) const {
  // Steps measure the phase as if by default shifts.
  if (const auto run = step_run(band)) {
    PhaseMaps maps = (*this)(frames, run->first, run->steps);
    if (run->shifts == Shifts{}) return maps;
    for (double& phase : maps.wrapped_phase) phase = unshifted_phase(run->shifts, phase);
    return maps;
  }

  // Any other weights: C and S first, in the place of modulation and phase.
  PhaseMaps maps{weighted_sum(frames, band.mean), weighted_sum(frames, band.cosine),
                 weighted_sum(frames, band.sine)};

  const auto bent = bent_run(band);
  const PhaseCorrection* correction = correction_for(bent ? bent->steps : 1);
  const Shifts shifts = bent ? bent->shifts : Shifts{};

  for_each_pixel(frames.size(), [&](int column, int row) {
    const double C = maps.modulation(column, row), S = maps.wrapped_phase(column, row);
    maps.modulation(column, row) = std::sqrt(S * S + C * C);  // (1.4)

    double& phi = maps.wrapped_phase(column, row);
    phi = wrapped_angle(S, C);  // (1.7)
    if (correction == nullptr) return;

    // The correction applies to phases with default shifts.
    const double seen = unshifted_phase({}, shifted_phase(shifts, phi));
    phi = unshifted_phase(shifts, corrected_phase(*correction, seen));
  });
  return maps;
}

PhaseEquations::PhaseEquations(int steps) {
  throw_if(steps < 3, "{} steps are too few; a phase requires 3 or more", steps);
  for (int n = 0; n < steps; ++n) {
    sines_.push_back(std::sin(2 * pi * n / steps));
    cosines_.push_back(std::cos(2 * pi * n / steps));
  }
}

PhaseSample PhaseEquations::operator()(std::span<const double> I) const {
  const std::size_t N = sines_.size();
  double sum = 0, S = 0, C = 0;

  for (std::size_t n = 0; n < N; ++n) {
    sum += I[n];
    S += I[n] * sines_[n];
    C += I[n] * cosines_[n];
  }

  S *= 2.0 / static_cast<double>(N);               // (1.5)
  C *= 2.0 / static_cast<double>(N);               // (1.6)
  return {.mean = sum / static_cast<double>(N),    // (1.3)
          .modulation = std::sqrt(S * S + C * C),  // (1.4)
          .wrapped_phase = wrapped_angle(S, C)};   // (1.7)
}

double wrapped_angle(double S, double C) {
  if (std::abs(S) < 1e-12 && std::abs(C) < 1e-12) return 0;
  double angle = std::atan2(S, C);
  if (angle < 0) angle += 2 * pi;
  return angle > 2 * pi - 1e-12 ? 0.0 : angle;
}

const ClosedForm* closed_form(int steps) {
  const auto form = std::ranges::find(closed_forms, steps, &ClosedForm::steps);
  return form == closed_forms.end() ? nullptr : &*form;
}

double least_reliable_reflectivity(double beta_p, double ambient) {
  if (ambient >= 0) return 0;
  const double lift = beta_p + ambient;
  return lift > 0 ? -ambient / lift : std::numeric_limits<double>::infinity();
}

}  // namespace slipstream
