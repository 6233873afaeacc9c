#include "slipstream/devices/monitor_sink.h"

#include <array>
#include <type_traits>

#include <GLFW/glfw3.h>
#include <epoxy/gl.h>
#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream::monitor {
namespace {

// One triangle that covers the picture.
constexpr const char* vertex_shader = R"(#version 330 core
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}
)";

// Texels are fetched by number, so that nothing is interpolated.
constexpr const char* fragment_shader = R"(#version 330 core
uniform sampler2D pattern;
uniform int height;
out vec4 pixel;
void main() {
  ivec2 place = ivec2(gl_FragCoord.xy);
  pixel = texelFetch(pattern, ivec2(place.x, height - 1 - place.y), 0);
}
)";

/// A grey one has one channel, which is read as three.
template <class Pixel>
opengl::Resource texture_of(const Image<Pixel>& pattern) {
  constexpr bool is_grey = std::is_same_v<Pixel, std::uint8_t>;
  static_assert(is_grey || sizeof(Pixel) == 3);
  opengl::Resource texture = opengl::make_texture();
  glBindTexture(GL_TEXTURE_2D, texture.number());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, is_grey ? GL_R8 : GL_RGB8, pattern.width(), pattern.height(), 0,
               is_grey ? GL_RED : GL_RGB, GL_UNSIGNED_BYTE, pattern.begin());
  if (is_grey) {
    constexpr std::array<GLint, 4> everywhere{GL_RED, GL_RED, GL_RED, GL_ONE};
    glTexParameteriv(GL_TEXTURE_2D, GL_TEXTURE_SWIZZLE_RGBA, everywhere.data());
  }
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

double refresh_hz_of(const opengl::WindowSystem& system, int monitor) {
  constexpr int usual_hz = 60;
  const auto monitors = system.monitors();
  const auto number = static_cast<std::size_t>(monitor);
  if (number >= monitors.size()) {
    throw Error(fmt::format("monitor {} is not there; {} connected, numbered from 0", monitor,
                            monitors.size()));
  }
  return monitors[number].refresh_hz > 0 ? monitors[number].refresh_hz : usual_hz;
}

}  // namespace

MonitorSink::MonitorSink(const opengl::WindowSystem& system, int monitor)
    : monitor_(monitor),
      refresh_hz_(refresh_hz_of(system, monitor)),
      window_(system, {.title = "slipstream project", .fills_monitor = monitor}),
      gamma_table_(system, monitor),
      program_({.vertex = vertex_shader, .fragment = fragment_shader}),
      vertex_array_(opengl::make_vertex_array()),
      size_(window_.framebuffer_size()) {
  glfwSetInputMode(window_.get(), GLFW_CURSOR, GLFW_CURSOR_HIDDEN);
  glfwSetKeyCallback(window_.get(), [](GLFWwindow* window, int key, int, int action, int) {
    if (key == GLFW_KEY_ESCAPE && action == GLFW_PRESS) glfwSetWindowShouldClose(window, GLFW_TRUE);
  });
  window_.wait_for_refresh(true);
  glDisable(GL_DITHER);
  glDisable(GL_FRAMEBUFFER_SRGB);
}

void MonitorSink::load(std::vector<Image<std::uint8_t>> patterns) {
  load_all(patterns);
}

void MonitorSink::load_in_colour(std::vector<Image<Colour>> pictures) {
  load_all(pictures);
}

template <class Pixel>
void MonitorSink::load_all(const std::vector<Image<Pixel>>& patterns) {
  require_patterns(patterns, size_, fmt::format("monitor {}", monitor_));
  window_.make_current();
  textures_.clear();
  for (const Image<Pixel>& pattern : patterns) textures_.push_back(texture_of(pattern));
}

void MonitorSink::show(std::size_t n) {
  window_.make_current();
  draw(n);
  window_.swap();
  glFinish();
  ++shown_;
}

void MonitorSink::draw(std::size_t n) const {
  glViewport(0, 0, size_.width, size_.height);
  program_.use();
  program_.set("pattern", 0);
  program_.set("height", size_.height);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, textures_.at(n).number());
  glBindVertexArray(vertex_array_.number());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
}

std::string MonitorSink::state() const {
  return has_gamma_table() ? "" : "the monitor has no gamma table that could be set";
}

bool MonitorSink::closed() const {
  glfwPollEvents();
  return window_.should_close();
}

}  // namespace slipstream::monitor
