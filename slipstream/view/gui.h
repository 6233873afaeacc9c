#pragma once

#include "slipstream/base/size.h"
#include "slipstream/view/window.h"

namespace slipstream::view {

/// How a framebuffer stands to the window that shows it.
struct Screen {
  Size window;              ///< the desktop's units, those of the mouse
  Size framebuffer;         ///< pixels
  float content_scale = 1;  ///< how large the desktop wants text

  /// Pixels for a unit of the window: 2 where the desktop hides HiDPI from windows.
  [[nodiscard]] float pixel_ratio() const;
  /// Window units for what takes one on an ordinary screen: 2 where it leaves HiDPI to them, and
  /// more in large windows, so that text keeps its share of them.
  [[nodiscard]] float unit() const;
};

Screen screen_of(const opengl::Window& window);

/// Dear ImGui: one at a time, for the context that is current.
class Gui {
 public:
  /// With the mouse and keys of the window, or without any where it is null: to draw off-screen.
  explicit Gui(const opengl::Window* window);
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;
  ~Gui();

  /// Widgets may be called from here to end_frame.
  void begin_frame(const Screen& screen);
  /// Draws them over the framebuffer that is bound.
  void end_frame();

 private:
  void set_scale(const Screen& screen);

  bool has_window_;
  float font_pixels_ = 0;
  float unit_ = 0;
};

}  // namespace slipstream::view
