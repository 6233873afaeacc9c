#include "check/fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/numbers.h"
#include "base/statistics.h"

namespace slipstream {
namespace {

using Complex = std::complex<double>;
using Place = ScanSamples::Place;

Complex direction_of(double periods) {
  return std::polar(1.0, two_pi * periods);
}

// Usual losses of modulation of fringes blurred in camera and projector.
constexpr std::array dampings{0.05, 0.1, 0.15, 0.2, 0.25};

/// On things of a few pixels, blur mixes the coordinates of both sides.
bool is_inside_surface(const ScanSamples& samples, std::size_t group) {
  return std::ranges::all_of(
      std::array{Place::right, Place::below, Place::far_right, Place::far_below},
      [&](Place place) { return samples.lit(group, place); });
}

}  // namespace

FrameJudge::FrameJudge(const FrameModel& model) : model_(model) {
  const std::size_t bands = model.bands().size();
  // Without a cue the coarsest band has no coarser coordinate to agree with.
  const std::size_t relations = bands - (model.has_real_cue() ? 0 : 1);

  evidence_.relations.resize(relations);
  mean_.resize(relations);
  between_.resize(relations);
  ratios_.resize(bands);
  if (model.has_real_cue()) damped_.resize(dampings.size());
}

void FrameJudge::clear() {
  std::ranges::fill(mean_, Complex{});
  std::ranges::fill(between_, std::array<Complex, 2>{});
  std::ranges::fill(damped_, Complex{});
  std::ranges::fill(ratios_, SharedSpread{});

  doubts_.clear();
  misfits_.clear();
  evidence_.coordinates.clear();

  residual_ = variation_ = by_origin_ = origin_square_ = 0;
  pairs_ = seams_ = far_pairs_ = 0;
}

double FrameJudge::ratio(const SampleReading& reading, std::size_t band) const {
  constexpr double nothing = 1;  // a grey level: about the noise of a modulation

  const auto level = [&](std::size_t b) {
    return std::log((reading.modulation[b] + nothing) / std::max(1e-3, reading.expected[b]));
  };

  return level(band) - level(model_.bands().front());
}

void FrameJudge::add_neighbour(const ScanSamples& samples, const FrameOrder& order,
                               std::size_t group, int side) {
  const Place place = side == 0 ? Place::right : Place::below;
  if (!samples.lit(group, place)) return;

  // Adjacent pixels separate signal from noise.
  model_.read(samples.levels(group, place), order, next_);
  add_pair(side, samples.variation(samples.levels(group, Place::middle)));

  auto& change = evidence_.coordinates.back().change;
  if (!change) return;

  change->coordinate[side] = next_.coordinate - here_.coordinate;
  change->phase[side] = change->coordinate[side];
  if (model_.layout().unwrapping->whole_stripes) return;

  const std::size_t band = model_.measuring_band();
  change->phase[side] = std::remainder(next_.phase[band] - here_.phase[band], two_pi) / two_pi /
                        model_.layout().bands[band].periods;
}

void FrameJudge::add_pair(int side, double variation) {
  ++pairs_;

  // Neighbours share their relation, so that only noise is left in the difference.
  for (std::size_t i = 0; i < between_.size(); ++i) {
    between_[i][side] += direction_of(here_.relations[i] - next_.relations[i]);
  }

  // Noise averages out of the products, a misfit of the patterns does not.
  for (std::size_t i = 0; i < here_.unexplained.size(); ++i) {
    residual_ += here_.unexplained[i] * next_.unexplained[i];
  }

  variation_ += variation;
  for (std::size_t b = 0; b < ratios_.size(); ++b) ratios_[b].add(ratio(here_, b), ratio(next_, b));
}

void FrameJudge::look_for_damping(double groups) {
  // Periods. Orders at the ends of the field are off by half of this: neighbours outvote it.
  constexpr double most_tolerated = 1.3;

  evidence_.damping = 0;
  if (damped_.empty() || evidence_.relations.front().agrees()) return;

  // The damping with which cue and fringes agree best, and well enough.
  BandRelation best = evidence_.relations.front();
  best.agreement = FitLimits::least_agreement;
  for (std::size_t i = 0; i < damped_.size(); ++i) {
    const double agreement = std::abs(damped_[i]) / groups / best.noise;
    const double offset = std::arg(damped_[i]) / two_pi;
    if (agreement < best.agreement || std::abs(offset) > FitLimits::most_offset) continue;

    best.agreement = agreement;
    best.offset = offset;
    evidence_.damping = dampings[i];
  }

  // Tolerate it where neighbours outvote the wrong orders.
  const double f = model_.layout().bands[model_.bands().front()].periods;
  if (evidence_.damping > 0 && f * evidence_.damping <= most_tolerated) {
    evidence_.relations.front() = best;
  }
}

void FrameJudge::sum_up(std::size_t groups) {
  constexpr double smallest = 1e-3;  // avoids division by zero

  const auto n = static_cast<double>(std::max<std::size_t>(1, groups));

  // The difference of two neighbours carries the noise of both: its coherence is the square of one
  // pixel's. A wrong relation that changes steadily along the picture differs in both directions,
  // which must not cancel; chance alone gives sums of sqrt(pairs).
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    const auto& [right, below] = between_[i];
    const double by_sides = std::abs(right) + std::abs(below) - 2 * std::sqrt(pairs_);
    const double coherent = std::max(std::abs(right + below), by_sides);
    const double noise = std::sqrt(coherent / std::max(1, pairs_));
    evidence_.relations[i] = {
        .agreement = std::abs(mean_[i]) / n / std::max(noise, smallest),
        .offset = std::arg(mean_[i]) / two_pi,
        .noise = noise,
        .error = std::sqrt(n / 2) / std::max(1.0, std::abs(mean_[i])) / two_pi};
  }

  look_for_damping(n);
  evidence_.residual = variation_ > 0 ? std::sqrt(std::max(0.0, residual_ / variation_)) : 0;

  // Close to their noise, single frames fit several orders almost as well as the right one. Right
  // scans in harsh light reach 1.6, another number of periods leaves 2 or more.
  constexpr double most_by_noise = 1.8;
  const bool by_noise = misfits_.empty() || quantile(misfits_, 0.5) <= most_by_noise;
  evidence_.doubt = by_noise ? 0 : quantile(doubts_, 0.5);
  evidence_.origin = origin_square_ > 0 ? by_origin_ / origin_square_ : 0;

  evidence_.ratio_spread = 0;
  for (const SharedSpread& of_band : ratios_) {
    evidence_.ratio_spread = std::max(evidence_.ratio_spread, of_band.deviation());
  }

  constexpr int at_depth_edges = 2;
  evidence_.seams =
      std::max(0, seams_ - at_depth_edges) / std::max(1.0, static_cast<double>(far_pairs_));
}

const FrameEvidence& FrameJudge::operator()(const ScanSamples& samples, const FrameOrder& order,
                                            std::size_t most_groups) {
  clear();

  const std::size_t groups = std::min(samples.groups(), most_groups);
  // A coarsest band of at most one period wraps: y may jump from one end to the other.
  const bool can_leap = !model_.has_real_cue() && model_.fewest_periods() <= 1;

  // 1. Each group's middle pixel, then its neighbours.
  for (std::size_t g = 0; g < groups; ++g) {
    const float* const levels = samples.levels(g, Place::middle);
    model_.read(levels, order, here_);
    evidence_.coordinates.push_back(
        {.pixel = {samples.column(g), samples.row(g)}, .coordinate = here_.coordinate});
    if (is_inside_surface(samples, g)) evidence_.coordinates.back().change.emplace();

    doubts_.push_back(here_.doubt);
    misfits_.push_back(here_.misfit);
    by_origin_ += here_.by_origin;
    origin_square_ += here_.origin_square;

    // Relations as directions in the complex plane: their mean shows how well they agree.
    for (std::size_t i = 0; i < mean_.size(); ++i) mean_[i] += direction_of(here_.relations[i]);
    // Damped fringes move the cue's coordinate away from the middle of the field.
    for (std::size_t i = 0; i < damped_.size(); ++i) {
      const double f = model_.layout().bands[model_.bands().front()].periods;
      damped_[i] += direction_of(here_.relations.front() - f * dampings[i] * (here_.coarse - 0.5));
    }

    for (const int side : {0, 1}) add_neighbour(samples, order, g, side);

    // Far ones show whether the coordinate jumps across the field.
    for (const Place place : {Place::far_right, Place::far_below}) {
      if (!can_leap || !samples.lit(g, place)) continue;
      const double f = model_.fewest_periods();
      const double a = f * here_.coarse, b = f * model_.coarse(samples.levels(g, place), order);

      // This close to the jump, noise alone carries a pixel across it.
      constexpr double margin = 0.004;
      if (std::min({a, 1 - a, b, 1 - b}) < margin) continue;

      ++far_pairs_;
      if (std::abs(a - b) > 0.8) ++seams_;
    }
  }

  // 2. Sums to evidence.
  sum_up(groups);
  return evidence_;
}

bool Fit::has_evidence() const {
  return std::ranges::none_of(frames.relations, &BandRelation::is_hidden);
}

bool Fit::bands_agree() const {
  return bands_alike() && std::ranges::all_of(frames.relations, &BandRelation::agrees);
}

const BandRelation* Fit::worst_relation() const {
  const BandRelation* worst = nullptr;
  const auto merit = [](const BandRelation& relation) {
    return relation.agreement - std::abs(relation.offset);
  };

  for (const BandRelation& relation : frames.relations) {
    if (relation.agrees()) continue;
    if (worst == nullptr || merit(relation) < merit(*worst)) worst = &relation;
  }

  return worst;
}

bool Fit::patterns_made() const {
  if (code.bits_are_sure()) return true;
  return frames.residual <= (moving ? FitLimits::most_residual_moving : FitLimits::most_residual);
}

bool Fit::code_agrees() const {
  return std::ranges::all_of(code_symptoms, [&](const CodeSymptom& symptom) {
    return std::abs(code.*symptom.value) <= symptom.limit;
  });
}

double Fit::most_falling() const {
  return FitLimits::most_falling + (code.bits_are_sure() ? code.unsure : 0);
}

bool Fit::geometry_fits() const {
  if (!geometry) return true;
  return geometry->slope + geometry->slope_doubt >= FitLimits::least_slope &&
         geometry->slope - geometry->slope_doubt <= FitLimits::most_slope &&
         (geometry->falling <= most_falling() || geometry->slope >= FitLimits::straight) &&
         geometry->without_point + geometry->outside <= FitLimits::most_outside;
}

bool Fit::poor() const {
  // Right scans: at most 0.05 and 0.001.
  constexpr double poor_offset = 0.06, poor_seams = 0.0015, poor_beyond = 0.5;

  const auto is_off = [](const BandRelation& relation) {
    return !relation.is_hidden() && std::abs(relation.offset) > poor_offset + 3 * relation.error;
  };

  return std::ranges::any_of(frames.relations, is_off) || frames.seams > poor_seams ||
         has_stray_points() || (geometry && geometry->beyond > poor_beyond);
}

bool Fit::has_stray_points() const {
  constexpr double most = 0.06;  // right scans: 0.04
  return geometry && geometry->outside + geometry->without_point > most;
}

double Fit::misfit() const {
  // Nearly every term is 1 at its limit.
  using L = FitLimits;
  double sum = frames.seams / L::most_seams + frames.ratio_spread / L::most_ratio_spread;
  sum += code.bits_are_sure() ? code.unsure : frames.residual / L::most_residual;

  for (const BandRelation& relation : frames.relations) {
    sum += std::max(0.0, 1 - relation.agreement) / (1 - L::least_agreement) +
           std::abs(relation.offset) / L::most_offset;
  }

  for (const CodeSymptom& symptom : code_symptoms) {
    sum += std::abs(code.*symptom.value) / symptom.limit;
  }

  if (geometry) {
    const double slope = geometry->slope, doubt = geometry->slope_doubt;
    // The uncertainty of the slope counts in its favour.
    const double nearest_to_one = std::clamp(1.0, slope - doubt, slope + doubt);

    sum += (geometry->without_point + geometry->outside) / L::most_outside +
           geometry->out_of_range / L::most_out_of_range + geometry->beyond +
           geometry->falling / most_falling() + std::abs(std::log(std::max(1e-3, nearest_to_one)));
  }

  return sum;
}

}  // namespace slipstream
