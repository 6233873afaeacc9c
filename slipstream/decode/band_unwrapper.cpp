#include "slipstream/decode/band_unwrapper.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "slipstream/base/numbers.h"
#include "slipstream/decode/temporal_unwrapping.h"

namespace slipstream {
namespace {

/// In [0, 2 pi).
double phase_of(const PhaseSum& sum, std::span<const double> phases) {
  double phi = 0;
  for (std::size_t i = 0; i < phases.size(); ++i) phi += sum.of[i] * phases[i];
  return phi - two_pi * std::floor(phi / two_pi);
}

}  // namespace

BandUnwrapper::BandUnwrapper(Layout layout, int projector_length)
    : layout_(std::move(layout)),
      projector_length_(projector_length),
      measuring_(measuring_band_index(layout_)),
      chain_(unwrapping_chain(layout_)),
      circle_(is_circle(layout_)),
      weights_(band_weights(layout_)) {
  if (layout_.unwrapping == Unwrapping::single_frames) {
    single_frames_.emplace(layout_, projector_length);
  }
}

bool BandUnwrapper::can_doubt() const {
  return chain_.size() > 1 || layout_.unwrapping == Unwrapping::likelihood ||
         layout_.unwrapping == Unwrapping::code || layout_.unwrapping == Unwrapping::single_frames;
}

BandUnwrapper::Coordinate BandUnwrapper::operator()(const Reading& reading) const {
  switch (layout_.unwrapping) {
    case Unwrapping::code_alone:
    case Unwrapping::code:
      return by_code(reading);
    case Unwrapping::likelihood:
      return likeliest(reading.phases, reading.modulations);
    case Unwrapping::single_frames: {
      const auto [y, doubt] = (*single_frames_)(reading.phases.front(), reading.intensities);
      return {y, doubt};
    }
    default:
      return by_chain(reading.phases);
  }
}

BandUnwrapper::Coordinate BandUnwrapper::by_chain(std::span<const double> phases) const {
  const double widest = 1 / chain_.front().periods;
  double y = unwrapped_coordinate(phase_of(chain_.front(), phases), 0, chain_.front().periods);
  if (!circle_) y = coordinate_in_field(y, widest, projector_length_);
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

BandUnwrapper::Coordinate BandUnwrapper::likeliest(std::span<const double> phases,
                                                   std::span<const double> modulations) const {
  const double f_h = layout_.bands[measuring_].periods;
  const double first = -0.5 / projector_length_;
  const auto residual = [&](std::size_t i, double y) {
    const double f = layout_.bands[i].periods;
    return fringe_order_residual(phases[i], f, y, fringe_order(phases[i], f, y));
  };
  double least = std::numeric_limits<double>::infinity(), likeliest = 0;
  for (int k = -1; k <= f_h; ++k) {
    const double y = unwrapped_coordinate(phases[measuring_], k, f_h);
    if (y < first || y >= first + 1) continue;
    // What is left by the coordinate of this order that fits all bands best.
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
  double doubt = 0;
  for (std::size_t i = 0; i < phases.size(); ++i) {
    doubt = std::max(doubt, std::abs(residual(i, likeliest)));
  }
  return {weighed(phases, likeliest), doubt};
}

BandUnwrapper::Coordinate BandUnwrapper::by_code(const Reading& reading) const {
  const auto [stripe, contrast] = read_code(*layout_.code, reading.intensities);
  const double y = (stripe + 0.5) / layout_.code->stripes;
  // Stripes begin between two pixels, whose centres are at whole numbers.
  if (layout_.unwrapping == Unwrapping::code_alone) {
    return {y - 0.5 / projector_length_, 0, contrast};
  }
  const double f = layout_.bands[measuring_].periods, phi = reading.phases[measuring_];
  const int k = fringe_order(phi, f, y);
  const double open = open_by_code(*layout_.code, f);
  const double beyond = std::abs(fringe_order_residual(phi, f, y, k)) - open;
  return {unwrapped_coordinate(phi, k, f), std::max(beyond, 0.0) / (1 - 2 * open)};
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

}  // namespace slipstream
