#include "check/frame_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/Cholesky>
#include <fmt/ranges.h>

#include "base/linear_algebra.h"
#include "base/numbers.h"
#include "decode/cue_evidence.h"
#include "decode/equations.h"
#include "decode/phase_decoder.h"
#include "response/correction.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

double dot(const std::vector<double>& weights, const float* levels, const FrameOrder& order) {
  double sum = 0;
  for (std::size_t n = 0; n < weights.size(); ++n) sum += weights[n] * levels[order[n]];
  return sum;
}

/// Rows: a basis of the space perpendicular to the patterns' shapes and to constant light. In a
/// window of declared motion, frames of one pattern differ: there, of each cycle on its own.
Eigen::MatrixXd complement_of(const Strategy& strategy, const Layout& layout) {
  // One cycle of the patterns; a longer window contains one from each of its first frames on.
  const std::optional<StepRun>& cycle = measuring_band(layout).cycle;
  const int count = cycle ? cycle->steps : layout.frames, cycles = layout.frames - count + 1;

  // Products of the patterns' shapes, summed over the field; the ones stand for constant light.
  const int places = std::max(128, 2 * count);
  Eigen::MatrixXd products = Eigen::MatrixXd::Ones(count, count);
  for (int i = 0; i < places; ++i) {
    Eigen::VectorXd pattern(count);

    // At irrational distances, to avoid aliasing with any period.
    const double y = std::fmod(i * std::numbers::phi, 1);
    const double across = std::fmod(i * std::numbers::sqrt2, 1);

    for (int n = 0; n < count; ++n) pattern[n] = strategy.shape(n, y, across);

    products += pattern * pattern.transpose() / places;
  }

  // Eigenvectors that no shape contains span the complement.
  const PrincipalAxes axes = principal_axes(products);
  const double least = 1e-9 * axes.values.maxCoeff();
  const auto unused = (axes.values.array() < least).count();

  // The same rows for each cycle, one frame later each time.
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(cycles * unused, layout.frames);
  for (int k = 0; k < cycles; ++k) {
    all.block(k * unused, k, unused, count) =
        axes.vectors.leftCols(unused).transpose() / std::sqrt(cycles);
  }

  return all;
}

/// The steps that the phases of a band are corrected for, 0 if they are not; then those of its
/// mirrored sinusoids.
std::vector<StepRun> steps_to_correct(const Band& band, const PhaseCorrections& corrections) {
  const auto run = bent_run(band);
  const int steps = run ? run->steps : 1;
  const int corrected = corrections.contains(steps) ? steps : 0;

  std::vector<StepRun> all{{.steps = corrected, .shifts = run ? run->shifts : Shifts{}}};
  for (const Band& mirrored : band.mirrored) {
    const auto of_mirrored = bent_run(mirrored);
    all.push_back({.steps = corrected, .shifts = of_mirrored ? of_mirrored->shifts : Shifts{}});
  }

  return all;
}

}  // namespace

FrameModel::FrameModel(const Sequence& sequence, const PhotometricCalibration& photometry,
                       const FrameModel* same_light)
    : sequence_(sequence),
      layout_(sequence.strategy.layout()),
      photometry_(photometry),
      chain_(coarse_to_fine(layout_)),
      identity_(layout_.frames),
      complement_(complement_of(sequence.strategy, layout_)) {
  std::iota(identity_.begin(), identity_.end(), 0);

  if (photometry.response) correct_for(photometry.response->response, same_light);

  // The correction that each band's steps need, if any.
  for (const Band& band : layout_.bands) corrected_.push_back(steps_to_correct(band, corrections_));

  // No band unwraps another here: only the measuring one is compared.
  if (order_source(layout_) == OrderSource::pixel) {
    chain_ = {slipstream::measuring_band_index(layout_)};
    alone_.emplace(layout_, length_along(sequence.axis, sequence.projector));
  }

  // A cue in the DC channel requires the ambient light.
  if (layout_.cue && (photometry.ambient || !needs_ambient_light(layout_))) {
    CueSettings settings{.light = sequence.light};
    settings.ambient = photometry.ambient.value_or(settings.ambient);
    settings.noise_variance = photometry.noise_variance.value_or(settings.noise_variance);
    cue_.emplace(layout_, settings);
  }
}

void FrameModel::correct_for(const Response& response, const FrameModel* same_light) {
  // With equal steps a correction depends on their number alone; other bands need their own.
  const auto is_known = [&](const Band& band) {
    const auto run = bent_run(band);
    return run && same_light->corrections_.contains(run->steps);
  };
  if (same_light != nullptr && std::ranges::all_of(layout_.bands, is_known)) {
    corrections_ = same_light->corrections_;
  } else {
    constexpr double accuracy = 1e-4;  // rad: far below the limits of the check
    corrections_ = phase_corrections(response, layout_, accuracy);
  }

  // The light of shapes from 0 to 1, with one more entry for interpolation at 1.
  if (same_light != nullptr) {
    light_ = same_light->light_;
    return;
  }
  constexpr int steps = 512;  // accurate to 1e-5 of the range
  const auto& [alpha_p, beta_p] = sequence_.light;
  for (int i = 0; i <= steps + 1; ++i) {
    const double shape = std::min(1.0, static_cast<double>(i) / steps);
    light_.push_back(light_at(response, (alpha_p * shape + beta_p) / 255));
  }
}

std::pair<double, double> FrameModel::sinusoid(const float* levels, const FrameOrder& order,
                                               const Band& band, const StepRun& steps) const {
  const double C = dot(band.cosine, levels, order);
  const double S = dot(band.sine, levels, order);
  const double modulation = std::sqrt(C * C + S * S), phase = wrapped_angle(S, C);

  if (steps.steps == 0) return {modulation, phase};

  // The correction applies to phases with default shifts.
  const double shifted = unshifted_phase({}, shifted_phase(steps.shifts, phase));
  const double corrected = corrected_phase(corrections_.at(steps.steps), shifted);

  return {modulation, unshifted_phase(steps.shifts, corrected)};
}

std::pair<double, double> FrameModel::demodulated(const float* levels, const FrameOrder& order,
                                                  std::size_t b) const {
  const Band& band = layout_.bands[b];
  auto [B, phi] = sinusoid(levels, order, band, corrected_[b].front());

  // With a carrier: the sum of both phases is free of it, the weaker sinusoid limits B.
  for (std::size_t i = 0; i < band.mirrored.size(); ++i) {
    const auto [other_B, other] = sinusoid(levels, order, band.mirrored[i], corrected_[b][i + 1]);
    B = std::min(B, other_B);
    phi = wrapped_sum(phi, other);
  }
  return {B, phi};
}

double FrameModel::coarse(const float* levels, const FrameOrder& order) const {
  return demodulated(levels, order, chain_.front()).second / two_pi / fewest_periods();
}

void FrameModel::read(const float* levels, const FrameOrder& order, SampleReading& reading) const {
  reading.phase.resize(layout_.bands.size());
  reading.modulation.resize(layout_.bands.size());

  // 1. Phase and modulation of each band.
  for (std::size_t b = 0; b < layout_.bands.size(); ++b) {
    std::tie(reading.modulation[b], reading.phase[b]) = demodulated(levels, order, b);
  }

  // 2. The coordinate, by the chain of bands or by all frames together.
  unwrap(reading, cue_ ? dot(layout_.cue->weights, levels, order) : 0);
  if (alone_) {
    std::vector<double> I;
    for (const int frame : order) I.push_back(levels[frame]);

    const PixelCoordinate found = (*alone_)({reading.phase, reading.modulation, I});
    reading.coordinate = found.y;
    reading.doubt = found.doubt;

    // The narrowest stripes may be blurred in good light.
    if (layout_.unwrapping->whole_stripes) reading.modulation.front() = found.contrast;

    if (!layout_.single_frames.empty()) fit_origin(levels, order, reading);
    if (chain_.size() < layout_.bands.size()) fit_origin(reading);
  }

  // The first sinusoid has the phase pi f y + 2 pi carrier x.
  if (const Band& band = layout_.bands[measuring_band()]; band.carrier > 0) {
    const double with_carrier =
        sinusoid(levels, order, band, corrected_[measuring_band()].front()).second;
    reading.across = (with_carrier / two_pi - band.periods / 2 * reading.coordinate) / band.carrier;
  }

  // 3. The part of the frames that no pattern explains.
  explain(levels, order, reading);
}

void FrameModel::unwrap(SampleReading& reading, double cue) const {
  const std::size_t first = chain_.front();
  reading.coarse = cue_ ? cue_->coordinate({.modulation = reading.modulation[0],
                                            .wrapped_phase = reading.phase[0],
                                            .cue = cue})
                        : reading.phase[first] / two_pi / layout_.bands[first].periods;

  // From coarse to fine: each relation, rounded, is the next fringe order.
  double y = reading.coarse;
  reading.relations.clear();
  for (std::size_t i = cue_ ? 0 : 1; i < chain_.size(); ++i) {
    const double f = layout_.bands[chain_[i]].periods;
    const double periods = reading.phase[chain_[i]] / two_pi;
    reading.relations.push_back(f * y - periods);
    y = (std::round(reading.relations.back()) + periods) / f;
  }

  reading.coordinate = y;
}

double FrameModel::edge_of_stripe(int stripe) const {
  const Code& code = *layout_.code;
  const int length = length_along(sequence_.axis, sequence_.projector);
  if (length == 0) return stripe / code.stripes;

  // Pixel x shows y = x / length, so the stripe begins half a pixel before its first pixel.
  return (first_pixel(code, stripe, length) - 0.5) / length;
}

double FrameModel::shape(int n, const SampleReading& reading) const {
  return sequence_.strategy.shape(n, std::clamp(reading.coordinate, 0.0, 1.0), reading.across);
}

double FrameModel::light(int n, const SampleReading& reading) const {
  if (light_.empty()) return shape(n, reading);

  const double place = shape(n, reading) * static_cast<double>(light_.size() - 2);
  const auto below = static_cast<std::size_t>(place);
  return light_[below] + (place - static_cast<double>(below)) * (light_[below + 1] - light_[below]);
}

void FrameModel::fit_origin(const float* levels, const FrameOrder& order,
                            SampleReading& reading) const {
  constexpr double step = 1e-5;

  // Columns: mean, modulation, coordinate. Blur removes any part of a response's harmonics: a
  // column more, if there are enough frames.
  const auto& known_response = photometry_.response;
  const bool is_bent = known_response && !is_linear(known_response->response) && layout_.frames > 4;
  Eigen::MatrixXd known(layout_.frames, is_bent ? 4 : 3);
  Eigen::MatrixX2d rest(layout_.frames, 2);  // the frames and their derivative by the origin

  SampleReading before = reading, after = reading;
  before.coordinate -= step;
  after.coordinate += step;

  for (int n = 0; n < layout_.frames; ++n) {
    const double slope = (shape(n, after) - shape(n, before)) / (2 * step);

    // The origin, in rad, moves a pattern of f periods by 1 / (2 pi f) of the field.
    const auto single = std::ranges::find(layout_.single_frames, n, &SingleFrame::frame);
    const double periods =
        single == layout_.single_frames.end() ? layout_.bands.front().periods : single->periods;

    known.row(n).head<3>() << 1, shape(n, reading), slope;
    if (is_bent) known(n, 3) = light(n, reading);
    rest.row(n) << levels[order[n]], slope / (two_pi * periods);
  }

  // Remove all that these explain.
  const Eigen::MatrixX2d fitted =
      (known.transpose() * known).ldlt().solve(known.transpose() * rest);
  rest -= known * fitted;

  if (photometry_.noise_variance) {
    const auto left = static_cast<double>(known.rows() - known.cols());
    reading.misfit = rest.col(0).squaredNorm() / left / *photometry_.noise_variance;
  }

  const double modulation = fitted(1, 0) + (is_bent ? fitted(3, 0) : 0);
  reading.by_origin = modulation * rest.col(0).dot(rest.col(1));
  reading.origin_square = modulation * modulation * rest.col(1).squaredNorm();
}

void FrameModel::fit_origin(SampleReading& reading) const {
  const auto count = static_cast<Eigen::Index>(layout_.bands.size());
  Eigen::VectorXd f(count), off(count);

  // How far each phase is from the coordinate, rad.
  for (Eigen::Index i = 0; i < count; ++i) {
    f[i] = layout_.bands[i].periods;
    const double apart = reading.phase[i] / two_pi - f[i] * reading.coordinate;
    off[i] = two_pi * (apart - std::round(apart));
  }

  // Without what another coordinate would do.
  const Eigen::VectorXd by = Eigen::VectorXd::Ones(count) - f * (f.sum() / f.squaredNorm());

  reading.by_origin = by.dot(off);
  reading.origin_square = by.squaredNorm();
}

Eigen::MatrixXd FrameModel::unexplained_at(const SampleReading& reading) const {
  constexpr double step = 1e-5;
  SampleReading before = reading, after = reading;
  before.coordinate -= step;
  after.coordinate += step;

  // Columns: mean, modulation, coordinate.
  Eigen::MatrixX3d known(layout_.frames, 3);
  for (int n = 0; n < layout_.frames; ++n) {
    known.row(n) << 1, light(n, reading), (light(n, after) - light(n, before)) / (2 * step);
  }

  return Eigen::MatrixXd::Identity(layout_.frames, layout_.frames) -
         known * (known.transpose() * known).ldlt().solve(known.transpose());
}

void FrameModel::explain(const float* levels, const FrameOrder& order,
                         SampleReading& reading) const {
  reading.unexplained.assign(unexplained_count(), 0);

  // A known response makes harmonics; subtract those expected at this coordinate.
  double alpha = 0;
  reading.made.clear();
  reading.expected.assign(layout_.bands.size(), 1);
  if (photometry_.response) {
    // Regression of the frames on the light of the patterns.
    double sum = 0, square = 0, level_sum = 0, product = 0;
    for (int n = 0; n < layout_.frames; ++n) {
      const double shown = light(n, reading), seen = levels[order[n]];
      reading.made.push_back(static_cast<float>(shown));
      sum += shown;
      square += shown * shown;
      level_sum += seen;
      product += shown * seen;
    }

    const double variation = square - sum * sum / layout_.frames;
    // The response changes the bands' modulations from place to place.
    for (std::size_t b = 0; b < layout_.bands.size(); ++b) {
      reading.expected[b] = sinusoid(reading.made.data(), identity_, layout_.bands[b], {}).first;
    }

    alpha = variation > 0 ? (product - sum * level_sum / layout_.frames) / variation : 0;
  }

  // Project the rest onto the complement of the shapes.
  for (int n = 0; n < layout_.frames; ++n) {
    double left = levels[order[n]];
    if (photometry_.response) left -= alpha * double{reading.made[n]};
    for (std::size_t i = 0; i < reading.unexplained.size(); ++i) {
      reading.unexplained[i] += complement_(i, n) * left;
    }
  }
}

FrameOrder composed(const FrameOrder& first, const FrameOrder& then) {
  if (first.empty()) return then;

  FrameOrder both;
  for (const int place : then) both.push_back(first.at(place));
  return both;
}

std::string text_of(const FrameOrder& order) {
  return fmt::format("{}", fmt::join(order, ","));
}

}  // namespace slipstream
