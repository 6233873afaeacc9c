#include "slipstream/decode/reflectivity.h"

#include <limits>

namespace slipstream {

double reflectivity(double modulation, double alpha_p, double share) {
  return 2 * modulation / (alpha_p * share);
}

double ambient_light(double mean, double alpha, const PatternLight& light) {
  return (mean - alpha * (light.alpha_p / 2 + light.beta_p)) / (alpha + 1);
}

double least_beta_p(double alpha, double ambient) {
  return ambient < 0 ? -(1 + 1 / alpha) * ambient : 0;
}

double least_reliable_reflectivity(double beta_p, double ambient) {
  if (ambient >= 0) return 0;
  const double lift = beta_p + ambient;
  return lift > 0 ? -ambient / lift : std::numeric_limits<double>::infinity();
}

double weighted_reflectivity(double alpha_1, double alpha_2, double c1) {
  return c1 * alpha_1 + (1 - c1) * alpha_2;
}

}  // namespace slipstream
