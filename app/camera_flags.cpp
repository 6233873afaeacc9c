#include "app/camera_flags.h"

#include <fmt/format.h>

#include "app/flag_group.h"
#include "slipstream/base/error.h"
#include "slipstream/base/rectangle.h"

namespace slipstream::app {

void add_camera_flags(CLI::App& command, CameraFlags& flags) {
  const FlagGroup group{command, "Camera"};
  group.add("--exposure", flags.exposure, "of each frame, ms");
  group.add("--gain", flags.gain, "in the camera's unit, mostly dB");
  group.add("--region", flags.region,
            "part of the sensor, width x height + x + y, as 640x480+16+8; for v4l2 the size");
  group.add("--pixel-format", flags.pixel_format,
            "Mono8, Mono10, Mono12, Mono16, or packed: Mono10p, Mono12p, Mono10Packed, "
            "Mono12Packed; RGB8: three patterns to a picture in colour");
  group.add("--trigger", flags.trigger,
            "the camera's input that starts each frame, as Line1; runs freely without");
  group.add("--packet-size", flags.packet_size, "GigE Vision, bytes; 0: the largest that passes");
}

CameraSettings camera_settings(const CameraFlags& flags) {
  CameraSettings settings;
  settings.gain = flags.gain;
  settings.pixel_format = pixel_format_named(flags.pixel_format);
  settings.trigger = flags.trigger;
  settings.packet_size = flags.packet_size;
  if (flags.exposure) settings.exposure = *flags.exposure / 1e3;
  if (flags.region) settings.region = rectangle_of_text(*flags.region);
  if (flags.region && !settings.region) {
    throw Error(fmt::format(
        "--region '{}' is no region; give width x height + x + y, as 640x480+16+8", *flags.region));
  }
  return settings;
}

}  // namespace slipstream::app
