#include "slipstream/view/point_renderer.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <vector>

#include <epoxy/gl.h>
#include <glm/gtc/type_ptr.hpp>

namespace slipstream::view {
namespace {

// The neighbours come from the same buffers, read some pixels and some rows further on: a slope
// costs no memory. Comparisons are written so that NaN fails them.
constexpr const char* vertex_shader = R"(#version 330 core
layout(location = 0) in float x;
layout(location = 1) in float y;
layout(location = 2) in float z;
layout(location = 3) in float value;
layout(location = 4) in float right_x;
layout(location = 5) in float right_y;
layout(location = 6) in float right_z;
layout(location = 7) in float lower_x;
layout(location = 8) in float lower_y;
layout(location = 9) in float lower_z;
uniform mat4 clip;
uniform float pixel_size;
uniform float size_depth;
uniform float largest_step;
uniform vec2 range;
uniform int coloured;
uniform int shaded;
uniform float floor_height;
uniform vec3 veil;
uniform float strength;
uniform sampler2D colours;
flat out vec3 colour;

float brightness(vec3 point) {
  const vec3 towards_light = normalize(vec3(-0.4, -0.5, -1.0));
  vec3 across = vec3(right_x, right_y, right_z) - point;
  vec3 down = vec3(lower_x, lower_y, lower_z) - point;
  bool on_one_surface = length(across) < largest_step && length(down) < largest_step;
  vec3 normal = cross(across, down);
  float size = length(normal);
  if (!(on_one_surface && size > 0.0)) return 0.82;
  return 0.30 + 0.70 * abs(dot(normal, towards_light)) / size;
}

void main() {
  vec3 point = vec3(x, y, z);
  bool drawn = abs(x) < 1e30 && abs(y) < floor_height && y < floor_height && abs(z) < 1e30;
  if (!drawn) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    gl_PointSize = 1.0;
    colour = veil;
    return;
  }
  gl_Position = clip * vec4(point, 1.0);
  float growth = size_depth > 0.0 ? max(z / size_depth, 0.1) : 1.0;
  gl_PointSize = clamp(growth * pixel_size / max(gl_Position.w, 1e-6), 1.0, 64.0);
  float share = clamp((( coloured != 0 ? z : value) - range.x) / (range.y - range.x), 0.0, 1.0);
  vec3 lit = coloured != 0 ? texture(colours, vec2(share * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb
                           : vec3(pow(share, 1.0 / 2.2));
  if (shaded != 0) lit *= brightness(point);
  colour = mix(veil, lit, strength);
}
)";

constexpr const char* fragment_shader = R"(#version 330 core
flat in vec3 colour;
out vec4 pixel;
void main() { pixel = vec4(colour, 1.0); }
)";

std::array<float, 3> as_array(const glm::vec3& vector) {
  return {vector.x, vector.y, vector.z};
}

/// How many pixels away the neighbours are that a slope is told from: over fewer the noise of depth
/// shows as grain, over more edges wear away.
constexpr std::size_t slope_reach = 3;

}  // namespace

PointRenderer::PointRenderer()
    : program_({.vertex = vertex_shader, .fragment = fragment_shader}),
      vertex_array_(opengl::make_vertex_array()) {
  for (opengl::Resource& buffer : buffers_) buffer = opengl::make_buffer();
  const ColourMap map = depth_colours();
  Image<Colour> colours({static_cast<int>(map.size()), 1});
  std::copy(map.begin(), map.end(), colours.begin());
  colours_.upload(colours);
}

void PointRenderer::upload(const PointImages& cloud, const Image<float>& value) {
  count_ = cloud.z.pixel_count();
  width_ = static_cast<std::size_t>(cloud.z.width());
  organised_ = cloud.z.height() > 1;
  upload_image(0, cloud.x);
  upload_image(1, cloud.y);
  upload_image(2, cloud.z);
  upload_image(3, value);
}

void PointRenderer::upload_image(std::size_t which, const Image<float>& image) {
  const std::size_t past_end = organised_ ? slope_reach * (width_ + 1) : 0;
  const std::vector<float> nothing(past_end, std::numeric_limits<float>::quiet_NaN());
  const auto bytes = [](std::size_t floats) {
    return static_cast<GLsizeiptr>(floats * sizeof(float));
  };
  glBindBuffer(GL_ARRAY_BUFFER, buffers_[which].number());
  // New memory each time, so that what is being drawn from the old is not waited for.
  glBufferData(GL_ARRAY_BUFFER, bytes(count_ + past_end), nullptr, GL_STREAM_DRAW);
  glBufferSubData(GL_ARRAY_BUFFER, 0, bytes(count_), image.begin());
  if (past_end != 0) {
    glBufferSubData(GL_ARRAY_BUFFER, bytes(count_), bytes(past_end), nothing.data());
  }
}

void PointRenderer::point_at(int every) const {
  const auto stride = static_cast<GLsizei>(static_cast<std::size_t>(every) * sizeof(float));
  const auto attribute = [&](GLuint location, std::size_t which, std::size_t first) {
    glBindBuffer(GL_ARRAY_BUFFER, buffers_[which].number());
    glVertexAttribPointer(location, 1, GL_FLOAT, GL_FALSE, stride,
                          std::bit_cast<const void*>(first * sizeof(float)));
    glEnableVertexAttribArray(location);
  };
  for (std::size_t which = 0; which < 4; ++which) {
    attribute(static_cast<GLuint>(which), which, 0);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    attribute(static_cast<GLuint>(4 + axis), axis, organised_ ? slope_reach : 0);
    attribute(static_cast<GLuint>(7 + axis), axis, organised_ ? slope_reach * width_ : 0);
  }
}

void PointRenderer::draw(const PointPass& pass) const {
  if (count_ == 0) return;
  program_.use();
  program_.set_matrix("clip", glm::value_ptr(pass.clip));
  program_.set("pixel_size", pass.point_size * pass.pixels_per_slope);
  program_.set("size_depth", organised_ ? pass.size_depth : 0.0F);
  program_.set("largest_step", pass.largest_step);
  program_.set("range",
               std::array{pass.range.low, std::max(pass.range.high, pass.range.low + 1e-6F)});
  program_.set("coloured", pass.coloured ? 1 : 0);
  program_.set("shaded", pass.shaded && organised_ ? 1 : 0);
  program_.set("floor_height", pass.floor);
  program_.set("veil", as_array(pass.veil));
  program_.set("strength", pass.strength);
  program_.set("colours", 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, colours_.number());
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_PROGRAM_POINT_SIZE);
  glDisable(GL_BLEND);
  glBindVertexArray(vertex_array_.number());
  point_at(pass.every);
  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(count_) / pass.every);
  glBindVertexArray(0);
}

}  // namespace slipstream::view
