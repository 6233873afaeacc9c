#include "slipstream/simulate/virtual_world.h"

#include "slipstream/noise/phase_noise.h"
#include "slipstream/simulate/named_scenes.h"

namespace slipstream {

PhotometricCalibration photometric_truth(const Photometry& photometry) {
  double variance = photometry.noise_variance;
  if (photometry.bits) {
    const double step = 255.0 / ((1 << *photometry.bits) - 1);
    variance += quantisation_variance * step * step;
  }
  PhotometricCalibration truth{.ambient = photometry.ambient};
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
  return scanner;
}

}  // namespace slipstream
