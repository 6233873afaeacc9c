#include "app/camera_flags.h"

#include <charconv>

#include <fmt/format.h>

#include "app/scan_flags.h"
#include "slipstream/error/error.h"

namespace slipstream::app {

namespace {

/// "640x480+16+8" or "640x480". Throws Error for anything else.
CameraRegion region_from(const std::string& text) {
  const std::size_t plus = text.find('+');
  CameraRegion region{.size = size_from(text.substr(0, plus), "--region")};
  if (plus == std::string::npos) return region;
  const char* const end = text.data() + text.size();
  const auto [middle, bad_x] = std::from_chars(text.data() + plus + 1, end, region.x);
  bool good = bad_x == std::errc() && middle != end && *middle == '+';
  if (good) {
    const auto [rest, bad_y] = std::from_chars(middle + 1, end, region.y);
    good = bad_y == std::errc() && rest == end && region.x >= 0 && region.y >= 0;
  }
  if (!good) {
    throw Error(
        fmt::format("--region '{}' is no region; give width x height + x + y, as "
                    "640x480+16+8",
                    text));
  }
  return region;
}

}  // namespace

void add_camera_flags(CLI::App& command, CameraFlags& flags) {
  const std::string group = "Camera";
  command.add_option("--exposure", flags.exposure, "of each frame, ms")->group(group);
  command.add_option("--gain", flags.gain, "in the camera's unit, mostly dB")->group(group);
  command
      .add_option("--region", flags.region,
                  "part of the sensor, width x height + x + y, as 640x480+16+8; for v4l2 the size")
      ->group(group);
  command
      .add_option("--pixel-format", flags.pixel_format,
                  "Mono8, Mono10, Mono12, Mono16, or packed: Mono10p, Mono12p, Mono10Packed, "
                  "Mono12Packed")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--trigger", flags.trigger,
                  "the camera's input that starts each frame, as Line1; runs freely without")
      ->group(group);
  command
      .add_option("--packet-size", flags.packet_size,
                  "GigE Vision, bytes; 0: the largest that passes")
      ->capture_default_str()
      ->group(group);
}

CameraSettings camera_settings(const CameraFlags& flags, std::optional<double> rate, int cycle) {
  CameraSettings settings;
  settings.gain = flags.gain;
  settings.frame_rate = rate;
  settings.pixel_format = mono_format_named(flags.pixel_format);
  settings.trigger = flags.trigger;
  settings.packet_size = flags.packet_size;
  settings.cycle = cycle;
  if (flags.exposure) settings.exposure = *flags.exposure / 1e3;
  if (flags.region) settings.region = region_from(*flags.region);
  return settings;
}

}  // namespace slipstream::app
