#include "slipstream/noise/phase_noise.h"

#include <numbers>

namespace slipstream {

using std::numbers::pi;

double phase_variance(int steps, double alpha, double alpha_p, double noise_variance) {
  return 8 * noise_variance / (steps * alpha * alpha * alpha_p * alpha_p);
}

double coordinate_variance(double phase_variance, double frequency) {
  return phase_variance / (4 * pi * pi * frequency * frequency);
}

}  // namespace slipstream
