#include "slipstream/view/points.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <epoxy/gl.h>

#include "slipstream/base/colour.h"
#include "slipstream/base/statistics.h"

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

/// Every so manyth pixel is looked at. Odd, so that all columns of a picture of even width are met.
std::size_t stride_over(std::size_t count) {
  constexpr std::size_t enough = 8192;
  return (count / enough) | 1U;
}

/// Organised: the median distance of a pixel's point to its neighbour's. A list of points: as if
/// they were spread over the largest side of their box.
float spacing_of(const PointImages& cloud, const Box& box) {
  const std::size_t count = cloud.z.pixel_count(), stride = stride_over(count);
  std::vector<float> distances;
  for (std::size_t i = 0; cloud.z.height() > 1 && i + 1 < count; i += stride) {
    const auto step = [i](const Image<float>& image) {
      return image.begin()[i + 1] - image.begin()[i];
    };
    const float distance = std::hypot(step(cloud.x), step(cloud.y), step(cloud.z));
    if (std::isfinite(distance) && distance > 0) distances.push_back(distance);
  }
  if (!distances.empty()) return quantile(distances, 0.5);
  const glm::vec3 sides = box.high - box.low;
  const float area = std::max({sides.x * sides.y, sides.y * sides.z, sides.x * sides.z});
  return std::sqrt(area / static_cast<float>(std::max<std::size_t>(count, 1)));
}

}  // namespace

Range robust_range(const Image<float>& values) {
  std::vector<float> finite = finite_values(values, stride_over(values.pixel_count()));
  if (finite.empty()) return {};
  return {quantile(finite, 0.01), quantile(finite, 0.99)};
}

CloudExtent extent_of(const PointImages& cloud) {
  const Range x = robust_range(cloud.x), y = robust_range(cloud.y), z = robust_range(cloud.z);
  CloudExtent extent{.box = {{x.low, y.low, z.low}, {x.high, y.high, z.high}}};
  extent.spacing = std::max(spacing_of(cloud, extent.box), 1e-6F);
  return extent;
}

float floor_height(const CloudExtent& extent) {
  return extent.box.high.y + 0.03F * extent.box.diagonal();
}

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
  program_.set("clip", pass.clip);
  program_.set("pixel_size", pass.point_size * pass.pixels_per_slope);
  program_.set("size_depth", organised_ ? pass.size_depth : 0.0F);
  program_.set("range",
               glm::vec2(pass.range.low, std::max(pass.range.high, pass.range.low + 1e-6F)));
  program_.set("coloured", pass.coloured ? 1 : 0);
  program_.set("floor_height", pass.floor);
  program_.set("veil", pass.veil);
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
