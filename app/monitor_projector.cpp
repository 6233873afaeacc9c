#include "app/monitor_projector.h"

#include <memory>
#include <optional>

#include "slipstream/error.h"

#ifdef SLIPSTREAM_VIEW
#include "devices/monitor.h"
#include "view/opengl.h"
#endif

namespace slipstream::app {

#ifdef SLIPSTREAM_VIEW

void require_desktop() {
  const opengl::WindowSystem desktop;
}

MonitorProjector open_projector(std::optional<int> monitor) {
  if (!monitor) return {};

  // The window must outlive the sink that draws into it, so `closed` holds both.
  struct Window {
    opengl::WindowSystem system;
    std::optional<monitor::MonitorSink> sink;
  };

  const auto window = std::make_shared<Window>();
  monitor::MonitorSink& sink = window->sink.emplace(window->system, *monitor);
  return {.sink = &sink, .refresh_hz = sink.refresh_hz(), .closed = [window] {
            return window->sink->closed();
          }};
}

#else

void require_desktop() {
  throw Error("this build has no window support; add --headless");
}

MonitorProjector open_projector(std::optional<int> monitor) {
  if (monitor) throw Error("--monitor: this build has no monitor support");
  return {};
}

#endif

}  // namespace slipstream::app
