#pragma once

#include <functional>
#include <optional>

#include "slipstream/frame_source.h"

namespace slipstream::app {

/// Throws WorldError without a desktop, Error for a build without windows; before work of seconds.
void require_desktop();

/// A monitor that shows the patterns.
struct MonitorProjector {
  PatternSink* sink = nullptr;  ///< null: none was requested
  double refresh_hz = 0;
  /// Whether its window was closed. Processes window events; main thread.
  std::function<bool()> closed = [] { return false; };
};

/// Throws Error for a missing monitor or a build without windows, WorldError without a desktop.
MonitorProjector open_projector(std::optional<int> monitor);

}  // namespace slipstream::app
