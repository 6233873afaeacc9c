#include "slipstream/codes/predicted_variance.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <vector>

#include <Eigen/Dense>

#include "slipstream/codes/unwrapping.h"

namespace slipstream {
namespace {

constexpr double square(double x) {
  return x * x;
}

double sum_of_squares(const std::vector<double>& weights) {
  return std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.0);
}

/// Of y by all frames of one mean and modulation, on average over the field, at sigma_w = B = 1.
double single_frames_variance(const Layout& layout) {
  constexpr int places = 509;
  constexpr double two_pi = 2 * std::numbers::pi;
  const Band& band = layout.bands.front();
  double sum = 0;
  for (int i = 0; i < places; ++i) {
    const double y = (i + 0.5) / places;
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    const auto add = [&](double periods, double shift) {
      const double a = two_pi * periods * y - shift;
      const Eigen::Vector3d row(1, std::cos(a), -two_pi * periods * std::sin(a));
      products += row * row.transpose();
    };
    for (std::size_t n = 0; n < band.mean.size(); ++n) {
      if (band.mean[n] != 0) add(band.periods, std::atan2(band.sine[n], band.cosine[n]));
    }
    for (const SingleFrame& single : layout.single_frames) add(single.periods, -single.origin);
    sum += products.inverse()(2, 2);
  }
  return sum / places;
}

}  // namespace

double phase_variance(int steps, double alpha, double alpha_p, double noise_variance) {
  return 8 * noise_variance / (steps * square(alpha * alpha_p));
}

double coordinate_variance(double phase_variance, double frequency) {
  return phase_variance / square(2 * std::numbers::pi * frequency);
}

double component_variance(const Band& band, double noise_variance) {
  return component_noise(band) * noise_variance;
}

double cue_variance(const Cue& cue, double noise_variance) {
  return sum_of_squares(cue.weights) * noise_variance;
}

double phase_variance(const Band& band, double modulation, double noise_variance) {
  return component_variance(band, noise_variance) / square(modulation);
}

double coordinate_variance(const Layout& layout, double modulation, double noise_variance) {
  if (way_of(layout.unwrapping).whole_stripes) return 1 / (12 * square(layout.code->stripes));
  if (layout.unwrapping == Unwrapping::single_frames) {
    return single_frames_variance(layout) * noise_variance / square(modulation);
  }
  const std::vector<double> weights = band_weights(layout);
  double variance = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const Band& band = layout.bands[i];
    variance += square(weights[i]) *
                coordinate_variance(phase_variance(band, modulation, noise_variance), band.periods);
  }
  return variance;
}

double reflectivity_variance(int steps, double alpha_p, double noise_variance, double share) {
  return 8 * noise_variance / (steps * square(alpha_p * share));
}

double weighted_reflectivity_variance(int steps, double alpha_p, double noise_variance) {
  return 16 * noise_variance / (steps * square(alpha_p));
}

double dc_reference_variance(double alpha, const PatternLight& light, double ambient, double c1,
                             double R) {
  const double c2 = 1 - c1;
  const double lever = 1 / c2 + 2 * (light.beta_p + ambient) / (light.alpha_p * c2) + R;
  return 4 / (3 * square(alpha * light.alpha_p)) * (1 / square(c2) + 2 * square(lever / c1));
}

double half_phase_reference_variance(double alpha, double alpha_p, double c1, double R) {
  const double c2 = 1 - c1;
  return (1 / square(c2) + 2 * square(R / c1)) / square(alpha * alpha_p);
}

}  // namespace slipstream
