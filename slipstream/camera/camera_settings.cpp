#include "slipstream/camera/camera_settings.h"

namespace slipstream {

std::optional<double>& asked_for(CameraSettings& settings, CameraControl which) {
  if (which == CameraControl::exposure) return settings.exposure;
  return which == CameraControl::gain ? settings.gain : settings.frame_rate;
}

}  // namespace slipstream
