#include "slipstream/simulate/virtual_world.h"

#include <cmath>

#include "slipstream/codes/predicted_variance.h"
#include "slipstream/simulate/named_scenes.h"

namespace slipstream {

Scanner as_calibrated(const VirtualWorld& world) {
  Scanner scanner = world.scanner;
  PhotometricCalibration& known = scanner.photometry;
  const Photometry& light = world.photometry;
  const Physics& physics = light.physics;
  const double step = light.bits ? 255.0 / ((1 << *light.bits) - 1) : 0;
  double variance = light.noise_variance + quantisation_variance * step * step;
  known.ambient = light.ambient;
  known.noise_gain = 0;
  if (physics.full_well > 0) {
    known.noise_gain = 255 / physics.full_well;
    variance += std::pow(known.noise_gain * physics.read_noise, 2) + known.noise_gain * 127.5;
  }
  variance += physics.row_noise * physics.row_noise;
  known.noise_variance = variance > 0 ? std::optional(variance) : std::nullopt;
  const double depth = working_volume(scanner).centre.z();
  scanner.calibrated_depths = {0.75 * depth, 1.25 * depth};
  return scanner;
}

}  // namespace slipstream
