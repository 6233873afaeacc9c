#pragma once

#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "slipstream/base/size.h"
#include "slipstream/view/resource.h"
#include "slipstream/view/shader_program.h"

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

}  // namespace slipstream::view
