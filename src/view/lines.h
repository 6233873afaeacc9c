#pragma once

#include <vector>

#include <glm/mat3x3.hpp>

#include "view/opengl.h"
#include "view/orbit_camera.h"

namespace slipstream::view {

struct Line {
  glm::vec3 from{0}, to{0};
  glm::vec3 colour{1};  ///< red, green, blue, 0 to 1
  float opacity = 1;
};

/// Straight anti-aliased lines of any width.
class LineRenderer {
 public:
  LineRenderer();

  /// Draws into the bound framebuffer of that size, with depth test. `width`: pixels.
  void draw(const std::vector<Line>& lines, const glm::mat4& clip, Size picture, float width) const;

 private:
  opengl::ShaderProgram program_;
  opengl::Resource vertex_array_, buffer_;
};

/// Axes at the box's lower left front corner, X red, Y green and Z blue, with letters facing the
/// eye. `directions`: of the axes in the scanner's frame, as columns.
std::vector<Line> axes(const Box& box, const OrbitCamera& camera,
                       const glm::mat3& directions = glm::mat3(1));

/// Spacing of the floor's grid: a round number of millimetres.
float grid_step(const Box& box);

/// The floor: lines along X and Z in the plane Y = `height`, under and around the box.
std::vector<Line> floor_grid(const Box& box, float height);

}  // namespace slipstream::view
