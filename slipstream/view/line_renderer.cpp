#include "slipstream/view/line_renderer.h"

#include <array>
#include <bit>
#include <cstddef>

#include <epoxy/gl.h>
#include <glm/gtc/type_ptr.hpp>

namespace slipstream::view {
namespace {

constexpr const char* line_vertex_shader = R"(#version 330 core
layout(location = 0) in vec3 point;
layout(location = 1) in vec4 colour;
uniform mat4 clip;
out vec4 end_colour;
void main() {
  gl_Position = clip * vec4(point, 1.0);
  end_colour = colour;
}
)";

// OpenGL 3.3 promises lines of one pixel only: each becomes a strip as wide as wanted and a pixel
// more, over which it fades. Ends behind the eye are first drawn to the near plane.
constexpr const char* geometry_shader = R"(#version 330 core
layout(lines) in;
layout(triangle_strip, max_vertices = 4) out;
in vec4 end_colour[];
uniform vec2 picture;
uniform float width;
out vec4 line_colour;
noperspective out float across;
void main() {
  vec4 a = gl_in[0].gl_Position, b = gl_in[1].gl_Position;
  float before_a = a.z + a.w, before_b = b.z + b.w;
  if (before_a <= 0.0 && before_b <= 0.0) return;
  if (before_a <= 0.0) a = mix(a, b, (1e-4 * before_b - before_a) / (before_b - before_a));
  if (before_b <= 0.0) b = mix(b, a, (1e-4 * before_a - before_b) / (before_a - before_b));
  vec2 along = (b.xy / b.w - a.xy / a.w) * picture;
  float size = length(along);
  if (!(size > 1e-6)) return;
  float reach = 0.5 * width + 1.0;
  vec2 side = vec2(-along.y, along.x) / size * 2.0 * reach / picture;
  for (int end = 0; end < 2; ++end) {
    vec4 place = end == 0 ? a : b;
    for (int sign = -1; sign <= 1; sign += 2) {
      gl_Position = place + vec4(float(sign) * side * place.w, 0.0, 0.0);
      line_colour = end_colour[end];
      across = float(sign) * reach;
      EmitVertex();
    }
  }
  EndPrimitive();
}
)";

constexpr const char* line_fragment_shader = R"(#version 330 core
in vec4 line_colour;
noperspective in float across;
uniform float width;
out vec4 pixel;
void main() {
  float cover = clamp(0.5 * width + 0.5 - abs(across), 0.0, 1.0);
  pixel = vec4(line_colour.rgb, line_colour.a * cover);
}
)";

struct Vertex {
  glm::vec3 point;
  glm::vec3 colour;
  float opacity;
};

std::vector<Vertex> vertices_of(const std::vector<Line>& lines) {
  std::vector<Vertex> vertices;
  vertices.reserve(2 * lines.size());
  for (const Line& line : lines) {
    vertices.push_back({line.from, line.colour, line.opacity});
    vertices.push_back({line.to, line.colour, line.opacity});
  }
  return vertices;
}

}  // namespace

LineRenderer::LineRenderer()
    : program_({.vertex = line_vertex_shader,
                .geometry = geometry_shader,
                .fragment = line_fragment_shader}),
      vertex_array_(opengl::make_vertex_array()),
      buffer_(opengl::make_buffer()) {
  glBindVertexArray(vertex_array_.number());
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.number());
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Vertex), nullptr);
  glVertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                        std::bit_cast<const void*>(offsetof(Vertex, colour)));
  glEnableVertexAttribArray(0);
  glEnableVertexAttribArray(1);
  glBindVertexArray(0);
}

void LineRenderer::draw(const std::vector<Line>& lines, const glm::mat4& clip, Size picture,
                        float width) const {
  const std::vector<Vertex> vertices = vertices_of(lines);
  if (vertices.empty()) return;
  program_.use();
  program_.set_matrix("clip", glm::value_ptr(clip));
  program_.set("picture",
               std::array{static_cast<float>(picture.width), static_cast<float>(picture.height)});
  program_.set("width", width);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glBindVertexArray(vertex_array_.number());
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.number());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)),
               vertices.data(), GL_STREAM_DRAW);
  glDrawArrays(GL_LINES, 0, static_cast<GLsizei>(vertices.size()));
  glBindVertexArray(0);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

}  // namespace slipstream::view
