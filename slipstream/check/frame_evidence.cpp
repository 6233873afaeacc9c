#include <algorithm>
#include <cmath>

#include "slipstream/base/numbers.h"
#include "slipstream/check/fit.h"

namespace slipstream {
namespace {

using Complex = std::complex<double>;
using Place = ScanSamples::Place;

Complex turned(double periods) {
  return std::polar(1.0, two_pi * periods);
}

/// Sum of squares about the mean over the frames.
double variation_of(const float* levels, int frames) {
  double sum = 0, squares = 0;
  for (int n = 0; n < frames; ++n) {
    const double level = levels[n];
    sum += level;
    squares += level * level;
  }
  return squares - sum * sum / frames;
}

}  // namespace

void FrameJudge::SharedSpread::add(double first, double second) {
  products += first * second;
  a += first;
  b += second;
  ++count;
}

double FrameJudge::SharedSpread::deviation() const {
  if (count == 0) return 0;
  return std::sqrt(std::max(0.0, products / count - a / count * (b / count)));
}

FrameJudge::FrameJudge(const FrameModel& model) : model_(model) {
  const std::size_t bands = model.bands().size();
  const std::size_t relations = bands - (model.has_real_cue() ? 0 : 1);
  evidence_.relations.resize(relations);
  mean_.resize(relations);
  between_.resize(relations);
  ratios_.resize(bands);
}

void FrameJudge::clear() {
  std::fill(mean_.begin(), mean_.end(), Complex{});
  std::fill(between_.begin(), between_.end(), Complex{});
  std::fill(ratios_.begin(), ratios_.end(), SharedSpread{});
  residual_ = variation_ = 0;
  pairs_ = seams_ = far_pairs_ = 0;
}

double FrameJudge::ratio(const SampleReading& reading, std::size_t band) const {
  constexpr double nothing = 1e-6;
  const std::size_t coarse = model_.bands().front();
  return std::log((reading.modulation[band] + nothing) / (reading.modulation[coarse] + nothing));
}

void FrameJudge::add_pair(double variation) {
  ++pairs_;
  for (std::size_t i = 0; i < between_.size(); ++i) {
    between_[i] += turned(here_.relations[i] - next_.relations[i]);
  }
  for (std::size_t i = 0; i < here_.unexplained.size(); ++i) {
    residual_ += here_.unexplained[i] * next_.unexplained[i];
  }
  variation_ += variation;
  for (std::size_t b = 0; b < ratios_.size(); ++b) {
    ratios_[b].add(ratio(here_, b), ratio(next_, b));
  }
}

void FrameJudge::add_far_pair() {
  const double f = model_.fewest_periods();
  const double a = f * here_.coarse, b = f * next_.coarse;
  // So near to the leap noise alone carries a pixel over it.
  constexpr double margin = 0.004;
  if (std::min({a, 1 - a, b, 1 - b}) < margin) return;
  ++far_pairs_;
  if (std::abs(a - b) > 0.8) ++seams_;
}

void FrameJudge::sum_up(std::size_t groups) {
  constexpr double least_noise = 1e-3;
  const auto n = static_cast<double>(std::max<std::size_t>(1, groups));
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    const double noise = std::sqrt(std::abs(between_[i]) / std::max(1, pairs_));
    evidence_.relations[i] = {.agreement = std::abs(mean_[i]) / n / std::max(noise, least_noise),
                              .offset = std::arg(mean_[i]) / two_pi,
                              .noise = noise};
  }
  evidence_.residual = variation_ > 0 ? std::sqrt(std::max(0.0, residual_ / variation_)) : 0;
  evidence_.ratio_spread = 0;
  for (const SharedSpread& of_band : ratios_) {
    evidence_.ratio_spread = std::max(evidence_.ratio_spread, of_band.deviation());
  }
  evidence_.seams = far_pairs_ > 0 ? static_cast<double>(seams_) / far_pairs_ : 0;
}

const FrameEvidence& FrameJudge::operator()(const ScanSamples& samples, const FrameOrder& order,
                                            std::size_t most_groups) {
  clear();
  const std::size_t groups = std::min(samples.groups(), most_groups);
  const bool can_leap = !model_.has_real_cue() && model_.fewest_periods() <= 1;
  for (std::size_t g = 0; g < groups; ++g) {
    const float* const levels = samples.levels(g, Place::middle);
    const double variation = variation_of(levels, samples.frames());
    model_.read(levels, order, here_);
    for (std::size_t i = 0; i < mean_.size(); ++i) mean_[i] += turned(here_.relations[i]);
    for (const Place place : {Place::right, Place::below}) {
      if (!samples.lit(g, place)) continue;
      model_.read(samples.levels(g, place), order, next_);
      add_pair(variation);
    }
    for (const Place place : {Place::far_right, Place::far_below}) {
      if (!can_leap || !samples.lit(g, place)) continue;
      model_.read(samples.levels(g, place), order, next_);
      add_far_pair();
    }
  }
  sum_up(groups);
  return evidence_;
}

std::optional<double> periods_that_agree(const FrameModel& model, const ScanSamples& samples,
                                         std::size_t relation) {
  constexpr int most = 160;
  constexpr double least_agreement = 0.5;
  const std::size_t link = relation + (model.has_real_cue() ? 0 : 1);
  const std::size_t band = model.bands()[link];
  const double before = link == 0 ? 1 : model.layout().bands[model.bands()[link - 1]].periods;
  const FrameOrder order = model.identity();
  std::vector<Complex> sums(most + 1);
  SampleReading reading;
  for (std::size_t g = 0; g < samples.groups(); ++g) {
    model.read(samples.levels(g, Place::middle), order, reading);
    const double y = link == 0 ? reading.coarse : reading.phase[model.bands()[link - 1]] / two_pi;
    const Complex step = turned(y);
    Complex turn = turned(-reading.phase[band] / two_pi);
    for (int k = 1; k <= most; ++k) {
      turn *= step;
      sums[static_cast<std::size_t>(k)] += turn;
    }
  }
  // In phase, not only alike: a right number leaves no offset.
  const auto best = std::max_element(sums.begin() + 1, sums.end(),
                                     [](Complex a, Complex b) { return a.real() < b.real(); });
  if (best->real() < least_agreement * static_cast<double>(samples.groups())) return std::nullopt;
  return static_cast<double>(best - sums.begin()) * before;
}

}  // namespace slipstream
