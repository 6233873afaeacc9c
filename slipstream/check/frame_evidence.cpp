#include "slipstream/check/frame_evidence.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>

#include <Eigen/Eigenvalues>

#include "slipstream/gamma/correction.h"
#include "slipstream/image/quantile.h"
#include "slipstream/phase/equations.h"

namespace slipstream {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

Complex turned(double periods) {
  return std::polar(1.0, 2 * pi * periods);
}

double dot(const std::vector<double>& weights, const float* levels, const FrameOrder& order) {
  double sum = 0;
  for (std::size_t n = 0; n < weights.size(); ++n) {
    sum += weights[n] * static_cast<double>(levels[order[n]]);
  }
  return sum;
}

/// Rows: an orthonormal basis of what is perpendicular to every pattern of that shape, with any
/// amount of constant light.
Eigen::MatrixXd complement_of(const Strategy& strategy) {
  constexpr int places = 509;  // prime, so that no period falls in step with it
  const int count = frame_count(strategy);
  Eigen::MatrixXd products = Eigen::MatrixXd::Ones(count, count);
  for (int i = 0; i < places; ++i) {
    Eigen::VectorXd pattern(count);
    for (int n = 0; n < count; ++n) pattern[n] = strategy.shape(n, (i + 0.5) / places);
    products += pattern * pattern.transpose() / places;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(products);
  const double least = 1e-9 * solver.eigenvalues().maxCoeff();
  const auto unused = (solver.eigenvalues().array() < least).count();
  return solver.eigenvectors().leftCols(unused).transpose();
}

/// Mean of a product over neighbours, without the noise that they do not share.
struct SharedSpread {
  double products = 0, a = 0, b = 0;
  int count = 0;

  void add(double first, double second) {
    products += first * second;
    a += first;
    b += second;
    ++count;
  }
  [[nodiscard]] double deviation() const {
    if (count == 0) return 0;
    return std::sqrt(std::max(0.0, products / count - a / count * (b / count)));
  }
};

}  // namespace

struct FrameModel::Reading {
  std::vector<double> cosine, sine, phase, modulation;  ///< of each band
  double cue = 0;

  explicit Reading(std::size_t bands)
      : cosine(bands), sine(bands), phase(bands), modulation(bands) {}
};

FrameModel::FrameModel(const Sequence& sequence, const PhotometricCalibration& photometry)
    : sequence_(sequence),
      layout_(sequence.strategy.layout()),
      photometry_(photometry),
      chain_(coarse_to_fine(layout_)),
      complement_(complement_of(sequence.strategy)) {
  if (photometry.response) {
    constexpr double accuracy = 1e-4;  // rad: far below what is asked here
    for (const int steps : step_counts(layout_)) {
      corrections_.try_emplace(steps,
                               phase_correction(photometry.response->response, steps, accuracy));
    }
  }
  for (const Band& band : layout_.bands) {
    const auto run = step_run(band);
    correction_steps_.push_back(run && corrections_.contains(run->steps) ? run->steps : 0);
  }
  if (layout_.cue) {
    CueSettings settings{.light = sequence.light};
    settings.ambient = photometry.ambient.value_or(settings.ambient);
    settings.noise_variance = photometry.noise_variance.value_or(settings.noise_variance);
    cue_.emplace(layout_, settings);
  }
}

FrameOrder FrameModel::identity() const {
  FrameOrder order(static_cast<std::size_t>(layout_.frames));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

void FrameModel::read(const float* levels, const FrameOrder& order, Reading& reading) const {
  for (std::size_t b = 0; b < layout_.bands.size(); ++b) {
    const Band& band = layout_.bands[b];
    const double C = dot(band.cosine, levels, order), S = dot(band.sine, levels, order);
    reading.cosine[b] = C;
    reading.sine[b] = S;
    reading.modulation[b] = std::hypot(C, S);
    reading.phase[b] = wrapped_angle(S, C);
    if (correction_steps_[b] != 0) {
      reading.phase[b] = corrected_phase(corrections_.at(correction_steps_[b]), reading.phase[b]);
    }
  }
  if (layout_.cue) reading.cue = dot(layout_.cue->weights, levels, order);
}

double FrameModel::coarse_coordinate(const Reading& reading) const {
  const std::size_t first = chain_.front();
  if (cue_) {
    return cue_->coordinate({.modulation = reading.modulation[0],
                             .wrapped_phase = reading.phase[0],
                             .cue = reading.cue});
  }
  return reading.phase[first] / (2 * pi) / layout_.bands[first].periods;
}

void FrameModel::relate(const Reading& reading, std::vector<double>& r) const {
  r.clear();
  double y = coarse_coordinate(reading);
  for (std::size_t i = cue_ ? 0 : 1; i < chain_.size(); ++i) {
    const double f = layout_.bands[chain_[i]].periods;
    const double periods = reading.phase[chain_[i]] / (2 * pi);
    r.push_back(f * y - periods);
    y = (std::round(r.back()) + periods) / f;
  }
}

double FrameModel::measured_coordinate(const Reading& reading) const {
  double y = coarse_coordinate(reading);
  for (std::size_t i = cue_ ? 0 : 1; i < chain_.size(); ++i) {
    const double f = layout_.bands[chain_[i]].periods;
    const double periods = reading.phase[chain_[i]] / (2 * pi);
    y = (std::round(f * y - periods) + periods) / f;
  }
  return y;
}

Eigen::VectorXd FrameModel::unexplained(const float* levels, const FrameOrder& order,
                                        const Reading& reading) const {
  Eigen::VectorXd I(layout_.frames);
  for (int n = 0; n < layout_.frames; ++n)
    I[n] = static_cast<double>(levels[order[static_cast<std::size_t>(n)]]);
  if (photometry_.response) {
    // A known response makes harmonics that are no fault: those of this place are taken away.
    const double y = std::clamp(measured_coordinate(reading), 0.0, 1.0);
    Eigen::VectorXd light(layout_.frames), shape(layout_.frames);
    for (int n = 0; n < layout_.frames; ++n) {
      shape[n] = sequence_.strategy.shape(n, y);
      light[n] = light_at(photometry_.response->response,
                          (sequence_.light.alpha_p * shape[n] + sequence_.light.beta_p) / 255);
    }
    const Eigen::VectorXd seen = I.array() - I.mean(), shown = light.array() - light.mean();
    const double alpha = shown.squaredNorm() > 0 ? seen.dot(shown) / shown.squaredNorm() : 0;
    I -= alpha * light;
  }
  return complement_ * I;
}

FrameEvidence FrameModel::evidence(const ScanSamples& samples, const FrameOrder& order) const {
  using Place = ScanSamples::Place;
  const std::size_t bands = layout_.bands.size();
  const std::size_t relations = chain_.size() - (cue_ ? 0 : 1);
  FrameEvidence result;
  result.groups = samples.groups();
  result.relations.resize(relations);

  Reading reading(bands), next(bands);
  std::vector<double> r, r_next;
  std::vector<Complex> mean(relations), between(relations);
  std::vector<SharedSpread> ratios(bands);
  std::vector<std::vector<double>> logarithms(bands);
  std::vector<double> turns(bands);
  double residual = 0, variation = 0;
  int pairs = 0, seams = 0, seam_pairs = 0;
  const double periods = least_periods(layout_);
  const std::size_t coarse = chain_.front();

  for (std::size_t g = 0; g < samples.groups(); ++g) {
    const float* const levels = samples.levels(g, Place::middle);
    read(levels, order, reading);
    relate(reading, r);
    for (std::size_t i = 0; i < relations; ++i) mean[i] += turned(r[i]);
    const Eigen::VectorXd e =
        complement_.rows() > 0 ? unexplained(levels, order, reading) : Eigen::VectorXd();
    for (std::size_t b = 0; b < bands; ++b) {
      const double ratio =
          std::log((reading.modulation[b] + 1e-6) / layout_.bands[b].share /
                   (reading.modulation[coarse] + 1e-6) * layout_.bands[coarse].share);
      logarithms[b].push_back(ratio);
    }
    for (const Place place : {Place::right, Place::below}) {
      if (!samples.lit(g, place)) continue;
      const float* const beside = samples.levels(g, place);
      read(beside, order, next);
      relate(next, r_next);
      ++pairs;
      for (std::size_t i = 0; i < relations; ++i) between[i] += turned(r[i] - r_next[i]);
      if (e.size() > 0) {
        residual += e.dot(unexplained(beside, order, next));
        double sum = 0, squares = 0;
        for (int n = 0; n < layout_.frames; ++n) {
          sum += levels[n];
          squares += static_cast<double>(levels[n]) * levels[n];
        }
        variation += squares - sum * sum / layout_.frames;
      }
      for (std::size_t b = 0; b < bands; ++b) {
        const double ratio =
            std::log((next.modulation[b] + 1e-6) / layout_.bands[b].share /
                     (next.modulation[coarse] + 1e-6) * layout_.bands[coarse].share);
        ratios[b].add(logarithms[b].back(), ratio);
        turns[b] += 1 - std::cos(reading.phase[b] - next.phase[b]);
      }
    }
    if (cue_ || periods > 1) continue;
    for (const Place place : {Place::far_right, Place::far_below}) {
      if (!samples.lit(g, place)) continue;
      read(samples.levels(g, place), order, next);
      const double a = periods * coarse_coordinate(reading), b = periods * coarse_coordinate(next);
      // So near to the leap noise alone carries a pixel over it.
      constexpr double margin = 0.004;
      if (std::min({a, 1 - a, b, 1 - b}) < margin) continue;
      ++seam_pairs;
      if (std::abs(a - b) > 0.8) ++seams;
    }
  }

  const auto n = static_cast<double>(std::max<std::size_t>(1, samples.groups()));
  for (std::size_t i = 0; i < relations; ++i) {
    const double noise = std::sqrt(std::abs(between[i]) / std::max(1, pairs));
    result.relations[i] = {.agreement = std::abs(mean[i]) / n / std::max(noise, 1e-3),
                           .offset = std::arg(mean[i]) / (2 * pi),
                           .noise = noise};
  }
  result.residual = variation > 0 ? std::sqrt(std::max(0.0, residual / variation)) : 0;
  for (std::size_t b = 0; b < bands; ++b) {
    result.modulation_ratios.push_back(
        logarithms[b].empty() ? 1 : std::exp(quantile(logarithms[b], 0.5)));
    result.ratio_spread = std::max(result.ratio_spread, ratios[b].deviation());
  }
  for (std::size_t i = 1; i < chain_.size(); ++i) {
    if (turns[chain_[i]] * 2 < turns[chain_[i - 1]]) result.ordered = false;
  }
  result.seams = seam_pairs > 0 ? static_cast<double>(seams) / seam_pairs : 0;
  return result;
}

SampleDecode FrameModel::decode(const ScanSamples& samples, std::size_t group,
                                ScanSamples::Place place, const FrameOrder& order) const {
  Reading reading(layout_.bands.size());
  read(samples.levels(group, place), order, reading);
  double modulation = std::numeric_limits<double>::infinity();
  for (std::size_t b = 0; b < layout_.bands.size(); ++b) {
    modulation = std::min(modulation, reading.modulation[b] / layout_.bands[b].share);
  }
  return {.coordinate = measured_coordinate(reading),
          .phase = reading.phase[chain_.back()],
          .modulation = modulation};
}

FrameModel::Gains FrameModel::gains(const ScanSamples& samples) const {
  const int count = layout_.frames;
  Gains result{.gains = std::vector<double>(static_cast<std::size_t>(count))};
  if (complement_.rows() == 0) return result;
  // (I + e)(1 + gain) leaves P diag(I) gain where P I of the truth is nothing; both sides of a
  // product are of different neighbours, which share no noise.
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
  double all = 0;
  Reading reading(layout_.bands.size()), next(layout_.bands.size());
  const FrameOrder order = identity();
  for (std::size_t g = 0; g < samples.groups(); ++g) {
    if (!samples.lit(g, ScanSamples::right)) continue;
    const float* const a = samples.levels(g, ScanSamples::middle);
    const float* const b = samples.levels(g, ScanSamples::right);
    read(a, order, reading);
    read(b, order, next);
    const Eigen::VectorXd e_a = unexplained(a, order, reading), e_b = unexplained(b, order, next);
    Eigen::MatrixXd d_a = complement_, d_b = complement_;
    for (int n = 0; n < count; ++n) {
      d_a.col(n) *= static_cast<double>(a[n]);
      d_b.col(n) *= static_cast<double>(b[n]);
    }
    normal += d_a.transpose() * d_b + d_b.transpose() * d_a;
    right += d_a.transpose() * e_b + d_b.transpose() * e_a;
    all += 2 * e_a.dot(e_b);
  }
  // All frames brighter alike are nothing to be seen: the mean is held at 0.
  const double held = normal.trace() / count;
  const Eigen::VectorXd gains =
      (normal + Eigen::MatrixXd::Constant(count, count, held)).ldlt().solve(right);
  result.explained = all > 0 ? gains.dot(right) / all : 0;
  std::copy(gains.begin(), gains.end(), result.gains.begin());
  return result;
}

std::optional<double> FrameModel::periods_that_agree(const ScanSamples& samples,
                                                     std::size_t relation,
                                                     const FrameOrder& order) const {
  const std::size_t link = relation + (cue_ ? 0 : 1);
  const double before = link == 0 ? 1 : layout_.bands[chain_[link - 1]].periods;
  constexpr int most = 160;
  std::vector<Complex> sums(most + 1);
  Reading reading(layout_.bands.size());
  for (std::size_t g = 0; g < samples.groups(); ++g) {
    read(samples.levels(g, ScanSamples::middle), order, reading);
    const double y =
        link == 0 ? coarse_coordinate(reading) : reading.phase[chain_[link - 1]] / (2 * pi);
    const Complex of_band = turned(-reading.phase[chain_[link]] / (2 * pi));
    const Complex step = turned(y);
    Complex turn = of_band;
    for (int k = 1; k <= most; ++k) {
      turn *= step;
      sums[static_cast<std::size_t>(k)] += turn;
    }
  }
  // In phase, not only alike: a right number leaves no offset.
  std::size_t best = 1;
  for (std::size_t k = 2; k <= most; ++k) {
    if (sums[k].real() > sums[best].real()) best = k;
  }
  if (sums[best].real() < 0.5 * static_cast<double>(samples.groups())) return std::nullopt;
  return static_cast<double>(best) * before;
}

}  // namespace slipstream
