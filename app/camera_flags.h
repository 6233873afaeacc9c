#pragma once

#include <optional>
#include <string>

#include <CLI/App.hpp>

#include "slipstream/devices/camera_settings.h"

namespace slipstream::app {

/// What a camera is to be set to, as far as it was given.
struct CameraFlags {
  std::optional<double> exposure;     ///< ms
  std::optional<double> gain;         ///< in the camera's unit
  std::optional<std::string> region;  ///< "640x480+16+8" or "640x480"
  std::string pixel_format = "Mono8";
  std::string trigger;
  int packet_size = 0;
};

/// Adds --exposure, --gain, --region, --pixel-format, --trigger and --packet-size.
void add_camera_flags(CLI::App& command, CameraFlags& flags);

/// As the library takes it. Throws Error for a region or a pixel format that is none.
CameraSettings camera_settings(const CameraFlags& flags);

}  // namespace slipstream::app
