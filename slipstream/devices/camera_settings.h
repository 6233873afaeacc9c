#pragma once

#include <optional>
#include <string>

#include "slipstream/base/rectangle.h"
#include "slipstream/devices/pixel_format.h"
#include "slipstream/frames/camera_controls.h"

namespace slipstream {

/// What a camera is set to; what is not given stays as the camera has it. Cameras of V4L2 take less
/// than those of GenICam, as said at each.
struct CameraSettings {
  std::optional<double> exposure;    ///< s; turns automatic exposure off
  std::optional<double> gain;        ///< in the camera's unit, mostly dB; V4L2: rounded
  std::optional<double> frame_rate;  ///< Hz, of a camera that runs freely; V4L2: the nearest
  /// V4L2: begins at 0, 0, and is 640x480 where not given.
  std::optional<Rectangle> region;
  /// V4L2: mono8 (the driver's GREY, or the luma of its YUYV), mono10 (Y10), mono12 (Y12) or
  /// rgb8 (RGB24). Frames in colour are three times as wide as the region: see ColourSource.
  PixelFormat pixel_format = PixelFormat::mono8;
  /// What starts each frame: empty: the camera runs freely, as V4L2 must; "Software":
  /// FrameSource::trigger; or the camera's name of a line, as "Line1".
  std::string trigger;
  int packet_size = 0;  ///< GigE Vision alone, bytes; 0: the largest that passes
  /// Patterns in a scan. When a camera was gone and is back, the count of its frames goes on at a
  /// multiple of it.
  int cycle = 1;
};

/// Where the settings say that control; exposure in seconds.
inline std::optional<double>& asked_for(CameraSettings& settings, CameraControl which) {
  if (which == CameraControl::exposure) return settings.exposure;
  return which == CameraControl::gain ? settings.gain : settings.frame_rate;
}

}  // namespace slipstream
