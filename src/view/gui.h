#pragma once

#include <string>
#include <vector>

#include "slipstream/measure.h"
#include "slipstream/viewer.h"
#include "view/opengl.h"
#include "view/scene_renderer.h"

struct ImVec2;

namespace slipstream::view {

/// Scales between a framebuffer and its window.
struct Screen {
  Size window{};            ///< desktop units, as for the mouse
  Size framebuffer{};       ///< pixels
  float content_scale = 1;  ///< the desktop's text scale

  /// Pixels per window unit: 2 if the desktop hides HiDPI from windows.
  [[nodiscard]] float pixel_ratio() const;
  /// Window units per unit on an ordinary screen: 2 if the desktop leaves HiDPI to windows; larger
  /// in large windows, so that text keeps its share.
  [[nodiscard]] float unit() const;
};

Screen screen_of(const opengl::Window& window);

/// Dear ImGui for the current OpenGL context; at most one at a time.
class Gui {
 public:
  /// Takes mouse and keys from the window; null: draws off-screen without input.
  explicit Gui(const opengl::Window* window);
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;
  ~Gui();

  /// Widgets may be drawn between begin_frame and end_frame.
  void begin_frame(const Screen& screen);
  /// Draws the widgets over the bound framebuffer.
  void end_frame();

 private:
  void set_scale(const Screen& screen);

  bool has_window_;
  float font_pixels_ = 0, unit_ = 0;
};

/// A part of the window, in window units from its upper left corner.
struct Area {
  float left = 0, top = 0, width = 0, height = 0;
};

// Overlays over the cloud, under the panel. `unit`: see Screen::unit.

/// Colour scale of depth in mm, in the lower right corner.
void draw_depth_scale(const Range& depths, const Area& area, float unit);

/// A short text in the middle, on a dark field.
void draw_note(const std::string& words, const Area& area, float unit);

/// A line of text at the lower edge.
void draw_footer(const std::string& words, const Area& area);

/// A rectangle between two opposite corners, in window units.
void draw_rectangle(const ImVec2& corner, const ImVec2& opposite);

/// Rings around points, and a line between two. `clip`: from the scanner's frame to clip
/// coordinates of the area.
void draw_ends(const std::vector<MeasuredPoint>& ends, const glm::mat4& clip, const Area& area,
               float unit);

/// The guide's picture as uploaded, and its text.
void draw_guide(const Guide& guide, const opengl::PictureTexture& picture, const Area& area);

/// A picture scaled to fit.
void draw_picture(const opengl::PictureTexture& picture, const Area& area);

}  // namespace slipstream::view
