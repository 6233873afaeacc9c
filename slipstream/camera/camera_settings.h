#pragma once

#include <optional>
#include <string>

#include "slipstream/camera/mono_pixels.h"
#include "slipstream/image/size.h"

namespace slipstream {

/// A part of the sensor.
struct CameraRegion {
  int x = 0;
  int y = 0;
  Size size;
};

/// What a camera is set to; what is not given stays as the camera has it.
struct CameraSettings {
  std::optional<double> exposure;    ///< s
  std::optional<double> gain;        ///< in the camera's unit, mostly dB
  std::optional<double> frame_rate;  ///< Hz; of a camera that runs freely
  std::optional<CameraRegion> region;
  MonoFormat pixel_format = MonoFormat::mono8;
  /// What starts each frame: empty: the camera runs freely; "Software": AravisSource::trigger; or
  /// the camera's name of a line, as "Line1".
  std::string trigger;
  int packet_size = 0;  ///< GigE Vision, bytes; 0: the largest that passes
  /// Patterns in a scan. When a camera was gone and is back, the count of its frames goes on at a
  /// multiple of it.
  int cycle = 1;
};

}  // namespace slipstream
