#pragma once

#include <optional>
#include <string>

#include <CLI/App.hpp>

#include "app/camera_flags.h"
#include "app/scan_flags.h"
#include "app/virtual_flags.h"
#include "slipstream/devices/named_source.h"

namespace slipstream::app {

/// The flags that say where frames come from and what they show.
struct SourceFlags {
  std::string source = "virtual";
  std::optional<double> rate;
  bool loop = false;
  std::optional<std::string> scanner;
  ScanFlags scan;
  VirtualFlags virtual_scanner;
  CameraFlags camera;
};

/// What the flags ask for. `marker`: a dark frame ends each cycle of patterns.
SourceRequest request_from(const SourceFlags& flags, bool marker = false);

}  // namespace slipstream::app
