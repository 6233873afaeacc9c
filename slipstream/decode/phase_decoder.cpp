#include "slipstream/decode/phase_decoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

#include "slipstream/base/parallel_rows.h"
#include "slipstream/decode/intensity_ratio.h"

namespace slipstream {
namespace {

constexpr std::array<std::pair<PhaseMethod, std::string_view>, 4> method_names{{
    {PhaseMethod::equation, "equation"},
    {PhaseMethod::closed_form, "closed-form"},
    {PhaseMethod::tables, "lut"},
    {PhaseMethod::intensity_ratio, "intensity-ratio"},
}};

/// Walks the pixels; `sample` turns the N intensities of one into a PhaseSample.
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

/// `sample` with its phase corrected, where there is a correction.
template <class Pixel, class Sample>
PhaseMaps decode_and_correct(const Frames<Pixel>& frames, const PhaseCorrection* correction,
                             const Sample& sample) {
  if (correction == nullptr) return decode_pixels<double>(frames, sample);
  return decode_pixels<double>(frames, [&](std::span<const double> I) {
    PhaseSample pixel = sample(I);
    pixel.wrapped_phase = corrected_phase(*correction, pixel.wrapped_phase);
    return pixel;
  });
}

template <class Pixel>
PhaseMaps decode_by_equations(const Frames<Pixel>& frames, const PhaseCorrection* correction) {
  return decode_and_correct(frames, correction, PhaseEquations(static_cast<int>(frames.size())));
}

template <class Pixel>
PhaseMaps decode_by_closed_form(const Frames<Pixel>& frames, const ClosedForm& form,
                                const PhaseCorrection* correction) {
  return decode_and_correct(frames, correction, [&](std::span<const double> I) -> PhaseSample {
    const auto [U, V] = table_index<double>(form, I);
    return {mean_of(I), form.modulation(U, V), form.wrapped_phase(U, V)};
  });
}

template <class Pixel>
PhaseMaps decode_by_ratio(const Frames<Pixel>& frames, const PhaseCorrection* correction) {
  const IntensityRatio ratio;
  const PhaseEquations equations(3);
  return decode_and_correct(frames, correction, [&](std::span<const double> I) {
    PhaseSample pixel = equations(I);
    pixel.wrapped_phase = ratio.wrapped_phase(I);
    return pixel;
  });
}

PhaseMaps decode_by_tables(const Frames<std::uint8_t>& frames, const PhaseTables& tables) {
  return decode_pixels<int>(frames, [&](std::span<const int> I) -> PhaseSample {
    const auto [U, V] = table_index<int>(tables.form(), I);
    return {mean_of(I), tables.mlut(U, V), tables.plut(U, V)};
  });
}

/// Of the two sinusoids of a band with a carrier: see Band::carrier.
void demodulate(PhaseMaps& maps, const PhaseMaps& mirrored) {
  std::transform(maps.modulation.begin(), maps.modulation.end(), mirrored.modulation.begin(),
                 maps.modulation.begin(), [](double a, double b) { return std::min(a, b); });
  std::transform(maps.wrapped_phase.begin(), maps.wrapped_phase.end(),
                 mirrored.wrapped_phase.begin(), maps.wrapped_phase.begin(), wrapped_sum);
}

}  // namespace

std::string_view name_of(PhaseMethod method) {
  for (const auto& [value, name] : method_names) {
    if (value == method) return name;
  }
  return "";
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
  const bool has_closed_form = closed_form(steps) != nullptr;
  const bool is_of_bytes = frames.visit(
      []<class Pixel>(const Frames<Pixel>&) { return std::is_same_v<Pixel, std::uint8_t>; });
  const bool has_table = tables_.contains(steps) && is_of_bytes;
  if (method_ == PhaseMethod::closed_form && has_closed_form) return PhaseMethod::closed_form;
  if (method_ == PhaseMethod::tables && has_table) return PhaseMethod::tables;
  if (method_ == PhaseMethod::intensity_ratio && steps == 3) return PhaseMethod::intensity_ratio;
  return PhaseMethod::equation;
}

PhaseMethod PhaseDecoder::method_for(const Band& band, const FrameViews& frames) const {
  const auto run = step_run(band);
  return run ? method_for(run->steps, frames) : PhaseMethod::equation;
}

PhaseMaps PhaseDecoder::operator()(const FrameViews& frames, int first, int steps) const {
  const PhaseMethod method = method_for(steps, frames);
  return frames.part(first, steps).visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (std::is_same_v<Pixel, std::uint8_t>) {
      if (method == PhaseMethod::tables) return decode_by_tables(views, tables_.at(steps));
    }
    const PhaseCorrection* correction = correction_for(steps);
    if (method == PhaseMethod::closed_form) {
      return decode_by_closed_form(views, *closed_form(steps), correction);
    }
    if (method == PhaseMethod::intensity_ratio) return decode_by_ratio(views, correction);
    return decode_by_equations(views, correction);
  });
}

PhaseMaps PhaseDecoder::operator()(const FrameViews& frames, const Band& band) const {
  PhaseMaps maps = sinusoid(frames, band);
  for (const Band& mirrored : band.mirrored) demodulate(maps, sinusoid(frames, mirrored));
  return maps;
}

PhaseMaps PhaseDecoder::sinusoid(const FrameViews& frames, const Band& band) const {
  if (const auto run = step_run(band)) {
    PhaseMaps maps = (*this)(frames, run->first, run->steps);
    if (run->shifts == Shifts{}) return maps;
    for (double& phase : maps.wrapped_phase) phase = unshifted_phase(run->shifts, phase);
    return maps;
  }
  PhaseMaps maps{weighted_sum(frames, band.mean), weighted_sum(frames, band.cosine),
                 weighted_sum(frames, band.sine)};
  const auto bent = bent_run(band);
  const PhaseCorrection* correction = bent ? correction_for(bent->steps) : nullptr;
  for_each_row(frames.size().height, [&](int row) {
    for (int column = 0; column < frames.size().width; ++column) {
      const double C = maps.modulation(column, row), S = maps.wrapped_phase(column, row);
      maps.modulation(column, row) = std::sqrt(S * S + C * C);  // (1.4)
      double& phi = maps.wrapped_phase(column, row);
      phi = wrapped_angle(S, C);  // (1.7)
      if (correction == nullptr) continue;
      const double seen = unshifted_phase({}, shifted_phase(bent->shifts, phi));
      phi = unshifted_phase(bent->shifts, corrected_phase(*correction, seen));
    }
  });
  return maps;
}

}  // namespace slipstream
