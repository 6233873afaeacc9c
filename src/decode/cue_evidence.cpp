#include "decode/cue_evidence.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "base/names.h"
#include "base/throw_if-inl.h"
#include "codes/predicted_variance.h"
#include "decode/equations.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

using std::numbers::pi;

}  // namespace

void require_valid(const CueSettings& settings) {
  require_valid(settings.light);
  throw_if(!(std::abs(settings.ambient) <= 255),
           "ambient light {} is out of range; -255 to 255 grey levels", settings.ambient);
  throw_if(!(settings.noise_variance > 0 && std::isfinite(settings.noise_variance)),
           "noise variance {} is out of range; above 0", settings.noise_variance);
  throw_if(!(settings.least_modulation >= 0),
           "least modulation {} is out of range; 0 grey levels or more", settings.least_modulation);
}

CueEvidence::CueEvidence(const Layout& layout, const CueSettings& settings)
    : settings_(settings), f_h_(layout.bands[0].periods) {
  cost_.circle = !layout.cue;
  cost_.c1 = layout.bands[0].share;
  cost_.component_variance = component_noise(layout.bands[0]) * settings.noise_variance;

  // A second band has the same noise as the first.
  if (cost_.circle) {
    cost_.c2 = layout.bands[1].share;
    cost_.cue_variance = cost_.component_variance;
    return;
  }

  // A cue in the DC channel also contains ambient light and the patterns' constant part.
  const auto& [alpha_p, beta_p] = settings.light;
  cost_.reference = layout.cue->reference;
  cost_.c2 = layout.cue->share;
  cost_.cue_variance = cue_variance(*layout.cue, settings.noise_variance);
  dc_ = std::round(layout.cue->dc());
  cost_.constant_light = dc_ * settings.ambient;
  cost_.steady = dc_ * (1 + 2 * (beta_p + settings.ambient) / alpha_p) / cost_.c1;
}

bool CueEvidence::lit(const CuePixel& pixel) const {
  return pixel.modulation * pixel.modulation > 16 * cost_.component_variance &&
         pixel.modulation >= settings_.least_modulation;
}

double CueEvidence::least_modulation() const {
  // In periods of the cue: for a uniform surface 0.3 % of the orders are wrong at this noise.
  constexpr double deviation = 0.6;

  if (cost_.circle)
    return cost_.c1 / cost_.c2 * std::sqrt(cost_.component_variance) * f_h_ / (2 * pi * deviation);

  // The largest noise of the cue over its change by a period, away from the ends of the field.
  double least = 0;
  for (double y = 0.15; y < 0.86; y += 0.05) {
    const double noise =
        std::sqrt(cost_.cue_variance + slope(y) * slope(y) * cost_.component_variance);
    const double period = std::abs(slope(y + 0.5 / f_h_) - slope(y - 0.5 / f_h_));
    least = std::max(least, noise / (period * deviation));
  }

  return least;
}

double CueEvidence::coordinate(const CuePixel& pixel) const {
  const auto& [alpha_p, beta_p] = settings_.light;
  const double beta = settings_.ambient;

  if (cost_.circle) return wrapped_angle(pixel.cue_sine, pixel.cue) / (2 * pi);  // (3.88)
  const double alpha = reflectivity(pixel.modulation, alpha_p, cost_.c1);        // (3.59)
  if (!(alpha > 1e-9)) return 0;

  const double R = (2 * (pixel.cue - dc_ * beta) / (alpha * alpha_p) -
                    dc_ * (2 * (beta_p + beta) / alpha_p + 1)) /
                   cost_.c2;  // (3.58), (3.74)
  return cost_.reference.inverse(R);
}

double CueEvidence::doubt(const CuePixel& pixel, double y) const {
  double periods = f_h_ * (coordinate(pixel) - y);
  if (cost_.circle) periods -= f_h_ * std::round(periods / f_h_);
  return std::min(std::abs(periods), 0.5);
}

double CueEvidence::cost(const CuePixel& pixel, double y) const {
  const double B = pixel.modulation;

  if (cost_.circle) {
    // The vector of both modulations against its projection on the direction given by y.
    const double along = pixel.cue * std::cos(2 * pi * y) + pixel.cue_sine * std::sin(2 * pi * y);
    const double projection = std::max(0.0, cost_.c1 * B + cost_.c2 * along);

    const double square = B * B + pixel.cue * pixel.cue + pixel.cue_sine * pixel.cue_sine -
                          projection * projection / (cost_.c1 * cost_.c1 + cost_.c2 * cost_.c2);
    return square / cost_.component_variance;
  }

  // The cue against its slope over B times B.
  const double at = slope(y);
  const double difference = pixel.cue - cost_.constant_light - at * B;

  // With a uniform prior on reflectivity; the logarithm remains from integrating over it.
  const double spread = 1 + cost_.component_variance / cost_.cue_variance * at * at;
  return difference * difference / (cost_.cue_variance * spread) + std::log(spread);
}

int CueEvidence::published_order(const CuePixel& pixel) const {
  const int k = fringe_order(pixel.wrapped_phase, f_h_, coordinate(pixel));
  return cost_.circle ? k : std::clamp(k, 0, static_cast<int>(f_h_) - 1);
}

int CueEvidence::nearest_order(const CuePixel& pixel, int projector_length) const {
  const int k = published_order(pixel);
  if (!cost_.circle) return k;

  const double y = unwrapped_coordinate(pixel.wrapped_phase, k, f_h_);
  return k +
         static_cast<int>(std::lround((coordinate_in_field(y, 1, projector_length) - y) * f_h_));
}

int CueEvidence::likeliest_order(const CuePixel& pixel, int projector_length) const {
  // On the circle all orders have the same noise: the nearest is the most likely.
  if (cost_.circle) return nearest_order(pixel, projector_length);

  // One order beyond either end of the field, where noise may carry a pixel.
  const int last = static_cast<int>(f_h_);
  double least = std::numeric_limits<double>::infinity();
  int best = 0;
  for (int k = -1; k <= last; ++k) {
    const double y = unwrapped_coordinate(pixel.wrapped_phase, k, f_h_);
    if (!near_field(y, projector_length)) continue;

    const double here = cost(pixel, y);
    if (here < least) {
      least = here;
      best = k;
    }
  }

  return best;
}

}  // namespace slipstream
