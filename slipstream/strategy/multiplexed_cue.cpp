#include "slipstream/strategy/multiplexed_cue.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "slipstream/noise/reflectivity.h"
#include "slipstream/phase/equations.h"
#include "slipstream/phase/temporal_unwrapping.h"

namespace slipstream {

using std::numbers::pi;

MultiplexedCue::MultiplexedCue(const PhaseChannelMultiplexing& strategy,
                               const CueSettings& settings)
    : strategy_(strategy),
      settings_(settings),
      f_h_(strategy.f_h()),
      c1_(strategy.c1()),
      c2_(strategy.c2()) {}

bool MultiplexedCue::lit(const MultiplexedPixel& pixel) const {
  const double variance = 2 * settings_.noise_variance / strategy_.steps;
  return pixel.modulation * pixel.modulation > 16 * variance &&
         pixel.modulation >= settings_.least_modulation;
}

double MultiplexedCue::coordinate(const MultiplexedPixel& pixel) const {
  const auto& [alpha_p, beta_p] = settings_.light;
  const double beta = settings_.ambient;
  if (strategy_.steps >= 5) return wrapped_angle(pixel.cue_sine, pixel.cue) / (2 * pi);  // (3.88)
  const double alpha = reflectivity(pixel.modulation, alpha_p, c1_);                     // (3.59)
  if (!(alpha > 1e-9)) return 0;
  const double R =
      strategy_.steps == 3
          ? (2 * (pixel.cue - beta) / (alpha * alpha_p) - 2 * (beta_p + beta) / alpha_p - 1) /
                c2_                                   // (3.58)
          : 2 * pixel.cue / (alpha * alpha_p * c2_);  // (3.74)
  return strategy_.inverse_R(R);
}

double MultiplexedCue::doubt(const MultiplexedPixel& pixel, double y) const {
  double periods = f_h_ * (coordinate(pixel) - y);
  if (strategy_.steps >= 5) periods -= f_h_ * std::round(periods / f_h_);
  return std::min(std::abs(periods), 0.5);
}

double MultiplexedCue::cost(const MultiplexedPixel& pixel, double y) const {
  const double B = pixel.modulation;
  const double N = strategy_.steps;
  if (N >= 5) {
    // The vector of both modulations against its projection on the direction that y gives it.
    const double along = pixel.cue * std::cos(2 * pi * y) + pixel.cue_sine * std::sin(2 * pi * y);
    const double projection = std::max(0.0, c1_ * B + c2_ * along);
    const double square = B * B + pixel.cue * pixel.cue + pixel.cue_sine * pixel.cue_sine -
                          projection * projection / (c1_ * c1_ + c2_ * c2_);
    return square / (2 * settings_.noise_variance / N);
  }
  const auto& [alpha_p, beta_p] = settings_.light;
  const double beta = settings_.ambient;
  // The cue's channel over B at this y, of any reflectivity: (3.56) / (3.57) and (3.73) / (3.72).
  const double dc = strategy_.steps == 3 ? 1 + 2 * (beta_p + beta) / alpha_p : 0;
  const double slope = (dc + c2_ * strategy_.R(y)) / c1_;
  const double channel = strategy_.steps == 3 ? pixel.cue - beta : pixel.cue;
  const double difference = channel - slope * B;
  // All reflectivities are as likely beforehand; the logarithm is what is left of them.
  const double spread = 1 + 2 * slope * slope;
  return difference * difference / (settings_.noise_variance / N * spread) + std::log(spread);
}

double MultiplexedCue::shade(const MultiplexedPixel& pixel, double y) const {
  return strategy_.steps == 3 ? pixel.modulation * c2_ / c1_ * strategy_.R(y) : 0;
}

int MultiplexedCue::published_order(const MultiplexedPixel& pixel) const {
  const int k = fringe_order(pixel.wrapped_phase, f_h_, coordinate(pixel));
  return strategy_.steps >= 5 ? k : std::clamp(k, 0, static_cast<int>(f_h_) - 1);
}

int MultiplexedCue::nearest_order(const MultiplexedPixel& pixel, int length) const {
  const int k = published_order(pixel);
  if (strategy_.steps < 5) return k;
  const double y = unwrapped_coordinate(pixel.wrapped_phase, k, f_h_);
  return k + static_cast<int>(std::lround((coordinate_in_field(y, 1, length) - y) * f_h_));
}

int MultiplexedCue::likeliest_order(const MultiplexedPixel& pixel, int length) const {
  // On the circle every order has the same noise: the nearest is the likeliest.
  if (strategy_.steps >= 5) return nearest_order(pixel, length);
  const int last = static_cast<int>(f_h_);
  double least = std::numeric_limits<double>::infinity();
  int best = 0;
  for (int k = -1; k <= last; ++k) {
    const double y = unwrapped_coordinate(pixel.wrapped_phase, k, f_h_);
    if (!near_field(y, length)) continue;
    const double here = cost(pixel, y);
    if (here < least) {
      least = here;
      best = k;
    }
  }
  return best;
}

bool MultiplexedCue::near_field(double y, int length) const {
  const double margin = 0.5 / length + 0.1 / f_h_;
  return y >= -margin && y <= 1 + margin;
}

}  // namespace slipstream
