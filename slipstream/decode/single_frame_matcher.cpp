#include "slipstream/decode/single_frame_matcher.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>

#include <Eigen/Dense>

#include "slipstream/base/numbers.h"
#include "slipstream/codes/sinusoid.h"
#include "slipstream/decode/temporal_unwrapping.h"

namespace slipstream {
namespace {}  // namespace

SingleFrameMatcher::SingleFrameMatcher(const Layout& layout, int projector_length)
    : waves_(static_cast<std::size_t>(layout.frames)),
      periods_(layout.bands.front().periods),
      first_(-0.5 / projector_length) {
  const Band& band = layout.bands.front();
  const StepRun run = *step_run(band);
  for (int n = 0; n < run.steps; ++n) {
    const auto frame = static_cast<std::size_t>(run.first + n);
    waves_[frame] = {periods_, std::atan2(band.sine[frame], band.cosine[frame])};
  }
  for (const auto& [frame, periods, origin] : layout.single_frames) {
    waves_[static_cast<std::size_t>(frame)] = {periods, -origin};
  }
}

std::pair<double, double> SingleFrameMatcher::operator()(double phi,
                                                         std::span<const double> I) const {
  // The waves at the first place, and what they turn by from each place to the next.
  const auto count = static_cast<double>(I.size());
  const double begin = unwrapped_coordinate(phi, -1, periods_);
  std::vector<std::complex<double>> wave(I.size()), turn(I.size());
  double sum = 0, square = 0;
  for (std::size_t n = 0; n < I.size(); ++n) {
    wave[n] = std::polar(1.0, two_pi * waves_[n].periods * begin - waves_[n].shift);
    turn[n] = std::polar(1.0, two_pi * waves_[n].periods / periods_);
    sum += I[n];
    square += I[n] * I[n];
  }
  const double variation = square - sum * sum / count;
  double least = std::numeric_limits<double>::infinity(), next = least, best = begin;
  for (int k = -1; k <= periods_; ++k) {
    double s = 0, ss = 0, sI = 0;
    for (std::size_t n = 0; n < I.size(); ++n) {
      const double shown = wave[n].real();
      s += shown;
      ss += shown * shown;
      sI += shown * I[n];
      wave[n] *= turn[n];
    }
    const double y = unwrapped_coordinate(phi, k, periods_);
    if (y < first_ || y >= first_ + 1) continue;
    // What a line through the points (shown, seen) leaves; a falling one explains nothing.
    const double covariance = std::max(sI - s * sum / count, 0.0);
    const double misfit = variation - covariance * covariance / (ss - s * s / count);
    if (misfit < least) {
      next = least;
      least = misfit;
      best = y;
    } else {
      next = std::min(next, misfit);
    }
  }
  const double doubt = next > 0 ? std::sqrt(std::max(least, 0.0) / next) / 2 : 0.5;
  return {refined(best, I), doubt};
}

double SingleFrameMatcher::refined(double y, std::span<const double> I) const {
  constexpr int steps = 4;
  const double most = 0.25 / periods_;
  const double from = y;
  for (int step = 0; step < steps; ++step) {
    // I = A + B cos(a) and its change with y, -2 pi f B sin(a).
    Eigen::Matrix2d products = Eigen::Matrix2d::Zero();
    Eigen::Vector2d sums = Eigen::Vector2d::Zero();
    for (std::size_t n = 0; n < I.size(); ++n) {
      const Eigen::Vector2d row(1, std::cos(two_pi * waves_[n].periods * y - waves_[n].shift));
      products += row * row.transpose();
      sums += I[n] * row;
    }
    const Eigen::Vector2d levels = products.ldlt().solve(sums);
    Eigen::Matrix3d all = Eigen::Matrix3d::Zero();
    Eigen::Vector3d misfit = Eigen::Vector3d::Zero();
    for (std::size_t n = 0; n < I.size(); ++n) {
      const auto& [f, shift] = waves_[n];
      const double a = two_pi * f * y - shift;
      const Eigen::Vector3d row(1, std::cos(a), -two_pi * f * levels[1] * std::sin(a));
      all += row * row.transpose();
      misfit += row * (I[n] - levels[0] - levels[1] * std::cos(a));
    }
    const double change = all.ldlt().solve(misfit)[2];
    if (!std::isfinite(change)) return from;
    y = std::clamp(y + change, from - most, from + most);
  }
  return y;
}

}  // namespace slipstream
