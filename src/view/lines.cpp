#include "view/lines.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <vector>

#include <epoxy/gl.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>

#include "view/opengl.h"
#include "view/orbit_camera.h"

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

// OpenGL 3.3 guarantees only lines of one pixel: each line becomes a strip of the requested width
// plus one pixel over which it fades. Ends behind the eye are first clipped to the near plane.
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
  glm::vec3 point, colour;
  float opacity;
};

constexpr glm::vec3 blue(0.36F, 0.60F, 1.0F), green(0.35F, 0.85F, 0.42F), red(1.0F, 0.38F, 0.34F);

/// A letter's stroke from x, y to z, w, in a square from -1 to 1, Y up.
using Stroke = glm::vec4;
constexpr std::array<Stroke, 2> letter_x{{{-0.7F, 1, 0.7F, -1}, {-0.7F, -1, 0.7F, 1}}};
constexpr std::array<Stroke, 3> letter_y{
    {{-0.7F, 1, 0, 0.05F}, {0.7F, 1, 0, 0.05F}, {0, 0.05F, 0, -1}}};
constexpr std::array<Stroke, 3> letter_z{
    {{-0.7F, 1, 0.7F, 1}, {0.7F, 1, -0.7F, -1}, {-0.7F, -1, 0.7F, -1}}};

}  // namespace

LineRenderer::LineRenderer()
    : program_({.vertex = line_vertex_shader,
                .geometry = geometry_shader,
                .fragment = line_fragment_shader}),
      vertex_array_(opengl::make_vertex_array()),
      buffer_(opengl::make_buffer()) {
  glBindVertexArray(*vertex_array_);
  glBindBuffer(GL_ARRAY_BUFFER, *buffer_);

  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Vertex), nullptr);
  glVertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                        std::bit_cast<const void*>(offsetof(Vertex, colour)));

  glEnableVertexAttribArray(0);
  glEnableVertexAttribArray(1);
  glBindVertexArray(0);
}

void LineRenderer::draw(const std::vector<Line>& lines, const glm::mat4& clip, Size picture,
                        float width) const {
  if (lines.empty()) return;

  // Both ends of each line.
  std::vector<Vertex> vertices;
  for (const Line& line : lines) {
    for (const glm::vec3& end : {line.from, line.to}) {
      vertices.push_back({end, line.colour, line.opacity});
    }
  }

  program_.use();
  glUniformMatrix4fv(program_.uniform("clip"), 1, GL_FALSE, glm::value_ptr(clip));
  glUniform2f(program_.uniform("picture"), static_cast<float>(picture.width),
              static_cast<float>(picture.height));
  glUniform1f(program_.uniform("width"), width);

  // Points hide lines, but transparent lines do not hide each other.
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);

  glBindVertexArray(*vertex_array_);
  glBindBuffer(GL_ARRAY_BUFFER, *buffer_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)),
               vertices.data(), GL_STREAM_DRAW);
  glDrawArrays(GL_LINES, 0, static_cast<GLsizei>(vertices.size()));
  glBindVertexArray(0);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

std::vector<Line> axes(const Box& box, const OrbitCamera& camera, const glm::mat3& directions) {
  const glm::vec3 sides = box.high - box.low;
  const glm::vec3 origin(box.low.x, box.high.y, box.low.z);

  const float length = 0.3F * std::max({sides.x, sides.y, sides.z});
  const float letter = 0.009F * camera.distance;

  // Directions of the picture in the scanner's frame.
  const glm::mat3 turn = glm::transpose(glm::mat3(view_matrix(camera)));
  const glm::vec3 right = in_display_frame(turn[0]), up = in_display_frame(turn[1]);

  std::vector<Line> lines;
  const auto add = [&](const glm::vec3& direction, std::span<const Stroke> strokes,
                       const glm::vec3& colour) {
    // An arm of the axes, and its letter a little beyond the end.
    const glm::vec3 end = origin + length * direction, middle = end + 1.9F * letter * direction;
    const auto place = [&](float x, float y) { return middle + letter * (x * right + y * up); };

    lines.push_back({origin, end, colour, 1});
    for (const Stroke& s : strokes) lines.push_back({place(s.x, s.y), place(s.z, s.w), colour, 1});
  };

  add(directions[0], letter_x, red);
  add(directions[1], letter_y, green);
  add(directions[2], letter_z, blue);

  return lines;
}

float grid_step(const Box& box) {
  const float wanted = std::max(box.diagonal(), 1e-3F) / 10;
  const float power = std::pow(10.0F, std::floor(std::log10(wanted)));

  // The next 1, 2 or 5 times a power of ten.
  for (const float factor : {1.0F, 2.0F, 5.0F}) {
    if (wanted <= factor * power) return factor * power;
  }

  return 10 * power;
}

std::vector<Line> floor_grid(const Box& box, float height) {
  constexpr glm::vec3 colour(0.62F, 0.66F, 0.72F);
  constexpr float opacity = 0.28F;
  const float step = grid_step(box), margin = 2 * step;

  // Whole steps, at least two beyond the box on each side.
  const auto first = [&](float low) { return std::floor((low - margin) / step) * step; };
  const auto last = [&](float high) { return std::ceil((high + margin) / step) * step; };
  const float left = first(box.low.x), right = last(box.high.x);
  const float front = first(box.low.z), back = last(box.high.z);

  std::vector<Line> lines;
  const auto add = [&](float from, float to, glm::vec3 begin, glm::vec3 end, int axis) {
    // Counted, as far from the origin adding a step may be lost in rounding.
    const float count = std::clamp(std::round((to - from) / step) + 1, 0.0F, 64.0F);
    for (int i = 0; i < static_cast<int>(count); ++i) {
      begin[axis] = end[axis] = from + static_cast<float>(i) * step;
      lines.push_back({begin, end, colour, opacity});
    }
  };

  add(left, right, {0, height, front}, {0, height, back}, 0);
  add(front, back, {left, height, 0}, {right, height, 0}, 2);

  return lines;
}

}  // namespace slipstream::view
