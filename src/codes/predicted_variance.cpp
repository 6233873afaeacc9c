#include "codes/predicted_variance.h"

#include <numbers>
#include <numeric>
#include <vector>

#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

constexpr double square(double x) {
  return x * x;
}

}  // namespace

double phase_variance(int steps, double alpha, double alpha_p, double noise_variance) {
  return 8 * noise_variance / (steps * square(alpha * alpha_p));
}

double coordinate_variance(double phase_variance, double frequency) {
  return phase_variance / square(2 * std::numbers::pi * frequency);
}

double cue_variance(const Cue& cue, double noise_variance) {
  const std::vector<double>& weights = cue.weights;
  return std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.0) * noise_variance;
}

double phase_variance(const Band& band, double modulation, double noise_variance) {
  return component_noise(band) * noise_variance / square(modulation);
}

double coordinate_variance(const Layout& layout, double modulation, double noise_variance) {
  const UnwrappingWay& way = *layout.unwrapping;
  // A code alone: uniform over the width of a stripe.
  if (way.whole_stripes) return 1 / (12 * square(layout.code->stripes));

  if (way.coordinate_variance != nullptr) {
    return way.coordinate_variance(layout) * noise_variance / square(modulation);
  }

  // Otherwise the weighted mean of the bands, whose noise is taken as independent.
  const std::vector<double> weights = band_weights(layout);
  double variance = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const Band& band = layout.bands[i];
    variance += square(weights[i]) *
                coordinate_variance(phase_variance(band, modulation, noise_variance), band.periods);
  }

  return variance;
}

double dc_reference_variance(double alpha, const PatternLight& light, double ambient, double c1,
                             double R) {
  const double c2 = 1 - c1;
  const double lever = 1 / c2 + 2 * (light.beta_p + ambient) / (light.alpha_p * c2) + R;
  return 4 / (3 * square(alpha * light.alpha_p)) * (1 / square(c2) + 2 * square(lever / c1));
}

}  // namespace slipstream
