#include "slipstream/view/point_renderer.h"

#include <algorithm>

#include <epoxy/gl.h>
#include <glm/gtc/type_ptr.hpp>

namespace slipstream::view {
namespace {

// Comparisons are written so that NaN fails them.
constexpr const char* point_vertex_shader = R"(#version 330 core
layout(location = 0) in float x;
layout(location = 1) in float y;
layout(location = 2) in float z;
layout(location = 3) in float value;
layout(location = 4) in float brightness;
uniform mat4 clip;
uniform float pixel_size;
uniform float size_depth;
uniform vec2 range;
uniform int coloured;
uniform float floor_height;
uniform vec3 veil;
uniform float strength;
uniform sampler2D colours;
flat out vec3 colour;

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
  colour = mix(veil, lit * brightness, strength);
}
)";

constexpr const char* point_fragment_shader = R"(#version 330 core
flat in vec3 colour;
out vec4 pixel;
void main() { pixel = vec4(colour, 1.0); }
)";

std::array<float, 3> as_array(const glm::vec3& vector) {
  return {vector.x, vector.y, vector.z};
}

}  // namespace

PointRenderer::PointRenderer()
    : program_({.vertex = point_vertex_shader, .fragment = point_fragment_shader}),
      vertex_array_(opengl::make_vertex_array()) {
  for (opengl::Resource& buffer : buffers_) buffer = opengl::make_buffer();
  const ColourMap map = depth_colours();
  Image<Colour> colours({static_cast<int>(map.size()), 1});
  std::copy(map.begin(), map.end(), colours.begin());
  colours_.upload(colours);
}

void PointRenderer::upload(const PointImages& cloud, const Image<float>& value) {
  count_ = cloud.z.pixel_count();
  organised_ = cloud.z.height() > 1;
  upload_image(0, cloud.x);
  upload_image(1, cloud.y);
  upload_image(2, cloud.z);
  upload_image(3, value);
  shaded_ = cloud.shading != nullptr;
  if (shaded_) upload_image(4, *cloud.shading);
}

void PointRenderer::upload_image(std::size_t which, const Image<float>& image) {
  const auto bytes = static_cast<GLsizeiptr>(count_ * sizeof(float));
  glBindBuffer(GL_ARRAY_BUFFER, buffers_[which].number());
  // New memory each time, so that what is being drawn from the old is not waited for.
  glBufferData(GL_ARRAY_BUFFER, bytes, image.begin(), GL_STREAM_DRAW);
}

void PointRenderer::point_at(int every, bool shaded) const {
  const auto stride = static_cast<GLsizei>(static_cast<std::size_t>(every) * sizeof(float));
  const GLuint count = shaded ? 5 : 4;
  for (GLuint which = 0; which < count; ++which) {
    glBindBuffer(GL_ARRAY_BUFFER, buffers_[which].number());
    glVertexAttribPointer(which, 1, GL_FLOAT, GL_FALSE, stride, nullptr);
    glEnableVertexAttribArray(which);
  }
  if (shaded) return;
  glDisableVertexAttribArray(4);
  glVertexAttrib1f(4, 1);
}

void PointRenderer::draw(const PointPass& pass) const {
  if (count_ == 0) return;
  program_.use();
  program_.set_matrix("clip", glm::value_ptr(pass.clip));
  program_.set("pixel_size", pass.point_size * pass.pixels_per_slope);
  program_.set("size_depth", organised_ ? pass.size_depth : 0.0F);
  program_.set("range",
               std::array{pass.range.low, std::max(pass.range.high, pass.range.low + 1e-6F)});
  program_.set("coloured", pass.coloured ? 1 : 0);
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
  point_at(pass.every, pass.shaded && shaded_);
  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(count_) / pass.every);
  glBindVertexArray(0);
}

}  // namespace slipstream::view
