#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `camera list`, and `camera serve` in builds with SLIPSTREAM_CAMERAS.
void add_camera(const Commands& program);

/// Adds `gpu list`, which lists the devices for --backend gpu.
void add_gpu(const Commands& program);

/// Adds `record`, which records the frames of a camera.
void add_record(const Commands& program);

}  // namespace slipstream::app
