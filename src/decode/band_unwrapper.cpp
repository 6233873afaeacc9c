#include "decode/band_unwrapper.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Dense>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "decode/decoder.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

/// Phase of the sum, [0, 2 pi).
double phase_of(const PhaseSum& sum, std::span<const double> phases) {
  double phi = 0;
  for (std::size_t i = 0; i < phases.size(); ++i) phi += sum.of[i] * phases[i];
  return phi - two_pi * std::floor(phi / two_pi);
}

}  // namespace

BandUnwrapper::BandUnwrapper(Layout layout, int projector_length, double noise)
    : layout_(std::move(layout)),
      projector_length_(projector_length),
      noise_(layout_.unwrapping->whole_stripes ? noise : 0),
      measuring_(measuring_band_index(layout_)),
      chain_(unwrapping_chain(layout_)),
      circle_(is_circle(layout_)),
      weights_(band_weights(layout_)) {
  if (layout_.unwrapping->pixel != nullptr) {
    own_ = layout_.unwrapping->pixel(layout_, projector_length_);
  }

  // Frames of the first band and single frames, in the order of the scan.
  if (!layout_.unwrapping->tries_orders || layout_.single_frames.empty()) return;
  waves_.resize(static_cast<std::size_t>(layout_.frames));
  for (const SingleFrame& wave : frames_of_sinusoids(layout_)) waves_[wave.frame] = wave;
}

PixelCoordinate BandUnwrapper::operator()(const PixelReading& reading) const {
  const UnwrappingWay& way = *layout_.unwrapping;

  if (own_) return own_(reading);
  if (way.reads_code) return by_code(reading);
  if (!way.tries_orders) return by_chain(reading.phases);
  if (waves_.empty()) return likeliest(reading.phases, reading.modulations);
  return by_single_frames(reading.phases.front(), reading.intensities);
}

PixelCoordinate BandUnwrapper::by_chain(std::span<const double> phases) const {
  // The first member has at most one period: it needs no fringe order.
  const double widest = 1 / chain_.front().periods;
  double y = unwrapped_coordinate(phase_of(chain_.front(), phases), 0, chain_.front().periods);
  if (!circle_) y = coordinate_in_field(y, widest, projector_length_);

  // Each further one gets its fringe order from the coordinate so far.
  double doubt = 0;
  for (std::size_t i = 1; i < chain_.size(); ++i) {
    const double phi = phase_of(chain_[i], phases), f = chain_[i].periods;

    const int k = fringe_order(phi, f, y);
    doubt = std::max(doubt, std::abs(fringe_order_residual(phi, f, y, k)));
    y = unwrapped_coordinate(phi, k, f);
  }

  y = weighed(phases, y);
  return {circle_ ? coordinate_in_field(y, widest, projector_length_) : y, doubt};
}

PixelCoordinate BandUnwrapper::likeliest(std::span<const double> phases,
                                         std::span<const double> modulations) const {
  const double f_h = layout_.bands[measuring_].periods;
  const double first = -0.5 / projector_length_;

  const auto residual = [&](std::size_t i, double y) {
    const double f = layout_.bands[i].periods;
    return fringe_order_residual(phases[i], f, y, fringe_order(phases[i], f, y));
  };

  // Try every order of the measuring band that lies in the field.
  double least = std::numeric_limits<double>::infinity(), likeliest = 0;
  for (int k = -1; k <= f_h; ++k) {
    const double y = unwrapped_coordinate(phases[measuring_], k, f_h);
    if (y < first || y >= first + 1) continue;

    // Residual at the coordinate of this order that fits all bands best.
    double square = 0, along = 0, length = 0;
    for (std::size_t i = 0; i < phases.size(); ++i) {
      const double apart = residual(i, y), f = layout_.bands[i].periods;
      const double weight = modulations[i] * modulations[i] / component_noise(layout_.bands[i]);
      square += weight * apart * apart;
      along += weight * apart * f;
      length += weight * f * f;
    }

    const double cost = length > 0 ? square - along * along / length : 0;
    if (cost < least) {
      least = cost;
      likeliest = y;
    }
  }

  // The band that agrees least gives the doubt.
  double doubt = 0;
  for (std::size_t i = 0; i < phases.size(); ++i) {
    doubt = std::max(doubt, std::abs(residual(i, likeliest)));
  }

  return {weighed(phases, likeliest), doubt};
}

PixelCoordinate BandUnwrapper::by_code(const PixelReading& reading) const {
  const auto [first, last, spread, contrast] =
      read_code(*layout_.code, reading.intensities, noise_);

  // The middle of the pixels that the stripes cover.
  if (layout_.unwrapping->whole_stripes) {
    const int begin = first_pixel(*layout_.code, first, projector_length_);
    const int end = first_pixel(*layout_.code, last + 1, projector_length_);
    return {(begin + end - 1) / (2.0 * projector_length_), std::min(0.5, spread / 8), contrast};
  }

  // The nearest order; the phase may leave the stripe's centre by `open` periods without doubt.
  const double y = (first + last + 1) / 2.0 / layout_.code->stripes;
  const double f = layout_.bands[measuring_].periods, phi = reading.phases[measuring_];
  const int k = fringe_order(phi, f, y);
  const double open = open_by_code(*layout_.code, f);
  const double beyond = std::abs(fringe_order_residual(phi, f, y, k)) - open;

  return {unwrapped_coordinate(phi, k, f), std::max(beyond, 0.0) / (1 - 2 * open)};
}

PixelCoordinate BandUnwrapper::by_single_frames(double phi, std::span<const double> I) const {
  const double f = layout_.bands.front().periods, first = -0.5 / projector_length_;

  // The waves at the first candidate, and their rotation from each candidate to the next.
  const auto count = static_cast<double>(I.size());
  const double begin = unwrapped_coordinate(phi, -1, f);
  std::vector<std::complex<double>> wave(I.size()), turn(I.size());

  double sum = 0, square = 0;
  for (std::size_t n = 0; n < I.size(); ++n) {
    wave[n] = std::polar(1.0, two_pi * waves_[n].periods * begin + waves_[n].origin);
    turn[n] = std::polar(1.0, two_pi * waves_[n].periods / f);
    sum += I[n];
    square += I[n] * I[n];
  }

  // Sums for the regression of the frames on each candidate's waves.
  const double variation = square - sum * sum / count;
  double least = std::numeric_limits<double>::infinity(), next = least, best = begin;
  for (int k = -1; k <= f; ++k) {
    double s = 0, ss = 0, sI = 0;
    for (std::size_t n = 0; n < I.size(); ++n) {
      const double shown = wave[n].real();
      s += shown;
      ss += shown * shown;
      sI += shown * I[n];
      wave[n] *= turn[n];
    }

    const double y = unwrapped_coordinate(phi, k, f);
    if (y < first || y >= first + 1) continue;

    // Residual of a line through the points (shown, seen); a falling line explains nothing.
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

  // Half of the ratio of the residuals' roots: 0 if clear, 0.5 if the next order fits as well.
  const double doubt = next > 0 ? std::sqrt(std::max(least, 0.0) / next) / 2 : 0.5;
  return {refined(best, I), doubt};
}

double BandUnwrapper::refined(double y, std::span<const double> I) const {
  constexpr int steps = 4;
  const double most = 0.25 / layout_.bands.front().periods;

  const double from = y;
  for (int step = 0; step < steps; ++step) {
    // 1. A and B at this y, in I = A + B cos(a).
    Eigen::Matrix2d products = Eigen::Matrix2d::Zero();
    Eigen::Vector2d sums = Eigen::Vector2d::Zero();
    for (std::size_t n = 0; n < I.size(); ++n) {
      const Eigen::Vector2d row(1, std::cos(two_pi * waves_[n].periods * y + waves_[n].origin));
      products += row * row.transpose();
      sums += I[n] * row;
    }

    const Eigen::Vector2d levels = products.ldlt().solve(sums);

    // 2. A step of Gauss-Newton in A, B and y; the derivative by y is -2 pi f B sin(a).
    Eigen::Matrix3d all = Eigen::Matrix3d::Zero();
    Eigen::Vector3d misfit = Eigen::Vector3d::Zero();
    for (std::size_t n = 0; n < I.size(); ++n) {
      const auto& [frame, f, origin] = waves_[n];
      const double a = two_pi * f * y + origin;
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

double BandUnwrapper::weighed(std::span<const double> phases, double y) const {
  if (weights_[measuring_] == 1) return y;

  double sum = 0;
  for (std::size_t i = 0; i < phases.size(); ++i) {
    const double f = layout_.bands[i].periods;
    if (weights_[i] == 0) continue;
    sum += weights_[i] * unwrapped_coordinate(phases[i], fringe_order(phases[i], f, y), f);
  }

  return sum;
}

UnwrappedPhases unwrap_pixels(const Layout& layout, const LayoutPhases& phases,
                              int projector_length, double noise) {
  const BandUnwrapper unwrapped(layout, projector_length, noise);
  const Size size = phases.bands.front().wrapped_phase.size();

  UnwrappedPhases result{.coordinate = Image<double>(size)};

  // A single band has nothing that could contradict it.
  const UnwrappingWay& way = *layout.unwrapping;
  const bool contradicted = way.pixel != nullptr || unwrapping_chain(layout).size() > 1 ||
                            way.tries_orders || way.reads_code;
  if (contradicted) result.doubt = Image<double>(size);

  const std::size_t bands = phases.bands.size();
  if (way.whole_stripes) result.contrast = Image<double>(size);

  phases.frames.visit([&](const auto& frames) {
    for_each_row(size.height, [&](int row) {
      std::vector<double> phase(bands), modulation(bands), I(frames.size());
      for (int column = 0; column < size.width; ++column) {
        for (std::size_t i = 0; i < bands; ++i) {
          phase[i] = phases.bands[i].wrapped_phase(column, row);
          modulation[i] = phases.bands[i].modulation(column, row);
        }

        for (std::size_t n = 0; n < I.size(); ++n) I[n] = frames[n](column, row);

        const auto [y, doubt, contrast] = unwrapped({phase, modulation, I});
        result.coordinate(column, row) = y;
        if (!result.doubt.empty()) result.doubt(column, row) = doubt;
        if (!result.contrast.empty()) result.contrast(column, row) = contrast;
      }
    });
  });

  return result;
}

}  // namespace slipstream
