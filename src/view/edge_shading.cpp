#include "view/edge_shading.h"

#include <numbers>

#include <epoxy/gl.h>

#include "view/opengl.h"
#include "view/orbit_camera.h"

namespace slipstream::view {
namespace {

/// One triangle over the whole pane.
constexpr const char* pane_vertex_shader = R"(#version 330 core
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
}
)";

constexpr const char* edge_fragment_shader = R"(#version 330 core
uniform sampler2D depths;
uniform float left;
uniform float reach;
uniform vec2 clip;
uniform float noise;
out vec4 pixel;

float depth_at(vec2 place) {
  ivec2 last = textureSize(depths, 0) - 1;
  return texelFetch(depths, clamp(ivec2(place), ivec2(0), last), 0).r;
}

// Logarithm of the distance from the eye: its differences are the same at any distance.
float distance_of(float depth) {
  return -log2(mix(1.0 / clip.x, 1.0 / clip.y, depth));
}

void main() {
  vec2 place = gl_FragCoord.xy - vec2(left, 0.0);
  float depth = depth_at(place);
  if (depth == 1.0) discard;  // the background

  float here = distance_of(depth), behind = 0.0;
  for (int i = 0; i < 8; ++i) {
    float angle = 0.785398 * float(i);
    vec2 neighbour = place + reach * vec2(cos(angle), sin(angle));
    behind += max(0.0, here - distance_of(depth_at(neighbour)) - noise) / 8.0;
  }

  pixel = vec4(vec3(exp(-100.0 * behind)), 1.0);
}
)";

}  // namespace

EdgeShading::EdgeShading()
    : program_({.vertex = pane_vertex_shader, .fragment = edge_fragment_shader}),
      vertex_array_(opengl::make_vertex_array()),
      depths_(opengl::make_texture()) {}

void EdgeShading::draw(const Pane& pane, float reach, float noise) const {
  // 1. The depths as drawn so far.
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, *depths_);
  glCopyTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, pane.left, 0, pane.size.width,
                   pane.size.height, 0);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);

  program_.use();
  glUniform1i(program_.uniform("depths"), 0);
  glUniform1f(program_.uniform("left"), static_cast<float>(pane.left));
  glUniform1f(program_.uniform("reach"), reach);
  glUniform2f(program_.uniform("clip"), nearest_share, farthest_share);

  // Four standard deviations: the difference of two noisy depths hardly reaches it.
  glUniform1f(program_.uniform("noise"), 4 * noise / std::numbers::ln2_v<float>);

  // 2. The colours times the brightness that the depths give.
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_DST_COLOR, GL_ZERO);
  glBindVertexArray(*vertex_array_);
  glDrawArrays(GL_TRIANGLES, 0, 3);

  glBindVertexArray(0);
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
}

}  // namespace slipstream::view
