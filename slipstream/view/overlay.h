#pragma once

#include <string>
#include <vector>

#include <glm/mat4x4.hpp>

#include "slipstream/cloud/measure.h"
#include "slipstream/view/cloud_extent.h"
#include "slipstream/view/picture_texture.h"

struct ImVec2;

namespace slipstream::view {

/// A part of the window, in its units, from its upper left corner.
struct Area {
  float left = 0;
  float top = 0;
  float width = 0;
  float height = 0;
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
