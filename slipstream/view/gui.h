#pragma once

#include "slipstream/cloud/measure.h"
#include "slipstream/view/scene_renderer.h"

struct ImVec2;

namespace slipstream::view {

/// How a framebuffer stands to the window that shows it.
struct Screen {
  Size window{};            ///< the desktop's units, those of the mouse
  Size framebuffer{};       ///< pixels
  float content_scale = 1;  ///< how large the desktop wants text

  /// Pixels for a unit of the window: 2 where the desktop hides HiDPI from windows.
  [[nodiscard]] float pixel_ratio() const;
  /// Window units for what takes one on an ordinary screen: 2 where the desktop leaves HiDPI to
  /// windows, and more in large ones, so that text keeps its share.
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
  float font_pixels_ = 0, unit_ = 0;
};

/// A part of the window, in its units, from its upper left corner.
struct Area {
  float left = 0, top = 0, width = 0, height = 0;
};

// What is drawn over the cloud, under the panel. `unit`: see Screen::unit.

/// The colours of depth beside their millimetres, in the lower right corner.
void draw_depth_scale(const Range& depths, const Area& area, float unit);

/// A few words in the middle, on a dark field.
void draw_note(const std::string& words, const Area& area, float unit);

/// A line at the lower edge.
void draw_footer(const std::string& words, const Area& area);

/// A frame between two opposite corners, in units of the window.
void draw_rectangle(const ImVec2& corner, const ImVec2& opposite);

/// Rings round points, and a line between two. `clip`: of the area, from the scanner's frame.
void draw_ends(const std::vector<MeasuredPoint>& ends, const glm::mat4& clip, const Area& area,
               float unit);

/// A picture as large as fits.
void draw_picture(const opengl::PictureTexture& picture, const Area& area);

}  // namespace slipstream::view
