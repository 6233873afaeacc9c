#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slipstream/base/size.h"

struct GLFWwindow;

namespace slipstream::opengl {

/// The connection to the desktop; one at a time, in the main thread, and outliving every Window.
class WindowSystem {
 public:
  /// Throws WorldError where there is no desktop to connect to.
  WindowSystem();
  WindowSystem(const WindowSystem&) = delete;
  WindowSystem& operator=(const WindowSystem&) = delete;
  ~WindowSystem();

  /// A screen, or a projector that is one.
  struct Monitor {
    std::string name;
    Size size;  ///< pixels
    int left = 0, top = 0;
    int refresh_hz = 0;
  };
  /// The first is the desktop's main one.
  [[nodiscard]] std::vector<Monitor> monitors() const;
};

/// How a window opens.
struct WindowSettings {
  std::string title = "slipstream";
  Size size{1280, 800};    ///< of its inside; the monitor's where it fills one
  bool visible = true;     ///< one that is not serves to draw off-screen
  int fills_monitor = -1;  ///< number of the monitor that it fills without a frame; none below 0
};

/// A window with an OpenGL 3.3 core context, which is current from its making on.
class Window {
 public:
  /// Throws Error for a monitor that is not there, WorldError where the desktop or its OpenGL does
  /// not give a window.
  Window(const WindowSystem& system, const WindowSettings& settings);

  [[nodiscard]] GLFWwindow* get() const { return window_.get(); }
  [[nodiscard]] Size size() const;              ///< in the desktop's units
  [[nodiscard]] Size framebuffer_size() const;  ///< in pixels
  [[nodiscard]] float content_scale() const;    ///< how large the desktop wants text: 2 on HiDPI
  [[nodiscard]] bool should_close() const;
  void make_current() const;
  /// Shows what was drawn, after the monitor's next refresh where `wait_for_refresh` was last true.
  void swap() const;
  void wait_for_refresh(bool wait) const;

 private:
  struct Close {
    void operator()(GLFWwindow* window) const;
  };
  std::unique_ptr<GLFWwindow, Close> window_;
};

/// An OpenGL 3.3 core context without a window, current from its making on: of EGL without any
/// surface, which needs no desktop, else of a hidden window. One at a time.
class OffScreenContext {
 public:
  /// Throws WorldError where neither is to be had.
  OffScreenContext();
  OffScreenContext(const OffScreenContext&) = delete;
  OffScreenContext& operator=(const OffScreenContext&) = delete;
  ~OffScreenContext() = default;

 private:
  std::shared_ptr<void> context_;  ///< of EGL, or the hidden window
};

}  // namespace slipstream::opengl
