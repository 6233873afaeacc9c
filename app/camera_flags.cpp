#include "app/camera_flags.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "app/scan_flags.h"
#include "slipstream/error/error.h"

namespace slipstream::app {

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

Region region_from(const std::string& text) {
  const std::size_t plus = text.find('+');
  Region region{.size = size_from(text.substr(0, plus), "--region")};
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

V4l2Settings v4l2_settings(const CameraFlags& flags, std::optional<double> rate, int cycle) {
  constexpr std::array<std::pair<std::string_view, int>, 3> bits_of{
      {{"Mono8", 8}, {"Mono10", 10}, {"Mono12", 12}}};
  V4l2Settings settings;
  settings.frame_rate = rate;
  settings.cycle = cycle;
  const auto* bits = std::find_if(bits_of.begin(), bits_of.end(), [&](const auto& known) {
    return known.first == flags.pixel_format;
  });
  if (bits == bits_of.end()) {
    throw Error(
        fmt::format("--pixel-format {} is not of a v4l2 camera; Mono8, Mono10 or Mono12 are",
                    flags.pixel_format));
  }
  settings.format.bits = bits->second;
  if (flags.region) {
    const Region region = region_from(*flags.region);
    if (region.x != 0 || region.y != 0) {
      throw Error(fmt::format("--region {}: a v4l2 camera has sizes, but no region; as 640x480",
                              *flags.region));
    }
    settings.format.size = region.size;
  }
  if (!flags.trigger.empty()) {
    throw Error(fmt::format("--trigger {}: v4l2 cameras run freely", flags.trigger));
  }
  if (flags.exposure) settings.exposure = *flags.exposure / 1e3;
  if (flags.gain) {
    if (!(std::abs(*flags.gain) <= std::numeric_limits<int>::max())) {
      throw Error(fmt::format("--gain {} is out of range; a whole number of 32 bits", *flags.gain));
    }
    settings.gain = static_cast<int>(std::lround(*flags.gain));
  }
  return settings;
}

}  // namespace slipstream::app
