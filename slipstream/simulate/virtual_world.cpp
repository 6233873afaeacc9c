#include "slipstream/simulate/virtual_world.h"

#include <cmath>

#include "slipstream/noise/phase_noise.h"
#include "slipstream/simulate/named_scenes.h"

namespace slipstream {

PhotometricCalibration photometric_truth(const Photometry& photometry) {
  double variance = photometry.noise_variance;
  if (photometry.bits) {
    const double step = 255.0 / ((1 << *photometry.bits) - 1);
    variance += quantisation_variance * step * step;
  }
  const Physics& physics = photometry.physics;
  PhotometricCalibration truth{.ambient = photometry.ambient};
  if (physics.full_well > 0) {
    truth.noise_gain = 255 / physics.full_well;
    variance += std::pow(truth.noise_gain * physics.read_noise, 2) + truth.noise_gain * 127.5;
  }
  variance += physics.row_noise * physics.row_noise;
  if (variance > 0) truth.noise_variance = variance;
  return truth;
}

Scanner as_calibrated(const VirtualWorld& world) {
  Scanner scanner = world.scanner;
  const PhotometricCalibration truth = photometric_truth(world.photometry);
  scanner.photometry.ambient = truth.ambient;
  scanner.photometry.noise_variance = truth.noise_variance;
  const double depth = working_volume(scanner).centre.z();
  scanner.calibrated_depths = {0.75 * depth, 1.25 * depth};
  scanner.photometry.noise_gain = truth.noise_gain;
  return scanner;
}

}  // namespace slipstream
