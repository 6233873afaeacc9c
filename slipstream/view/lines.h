#pragma once

#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "slipstream/base/size.h"
#include "slipstream/view/opengl.h"
#include "slipstream/view/orbit_camera.h"

namespace slipstream::view {

struct Line {
  glm::vec3 from{0};
  glm::vec3 to{0};
  glm::vec3 colour{1};  ///< red, green, blue, 0 to 1
  float opacity = 1;
};

/// Straight lines of any width with smooth edges.
class LineRenderer {
 public:
  LineRenderer();

  /// Into the bound framebuffer of that size, behind what is nearer. `width`: pixels.
  void draw(const std::vector<Line>& lines, const glm::mat4& clip, Size picture, float width) const;

 private:
  opengl::ShaderProgram program_;
  opengl::Resource vertex_array_, buffer_;
};

/// The scanner's axes along the edges of the box from its lower left front corner, X blue, Y green
/// and Z red as in Liu 2010, Fig. 2.3, with their letters, which face the eye.
std::vector<Line> axes(const Box& box, const OrbitCamera& camera);

/// Distance between the lines of the floor's grid: a round number of millimetres.
float grid_step(const Box& box);

/// The floor: lines along X and Z in the plane Y = `height` under the box and round it.
std::vector<Line> floor_grid(const Box& box, float height);

}  // namespace slipstream::view
