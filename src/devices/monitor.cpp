#include "devices/monitor.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include <GLFW/glfw3.h>
#include <epoxy/gl.h>

#include "base/throw_if-inl.h"
#include "view/opengl.h"

namespace slipstream::monitor {
namespace {

// One triangle that covers the picture.
constexpr const char* vertex_shader = R"(#version 330 core
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}
)";

// Texels are fetched by index, without interpolation.
constexpr const char* fragment_shader = R"(#version 330 core
uniform sampler2D pattern;
uniform int height;
out vec4 pixel;
void main() {
  ivec2 place = ivec2(gl_FragCoord.xy);
  pixel = texelFetch(pattern, ivec2(place.x, height - 1 - place.y), 0);
}
)";

/// A grey picture has one channel, read as three.
template <class Pixel>
opengl::Resource texture_of(const Image<Pixel>& pattern) {
  constexpr bool is_grey = std::is_same_v<Pixel, std::uint8_t>;
  static_assert(is_grey || sizeof(Pixel) == 3);

  opengl::Resource texture = opengl::make_texture();
  glBindTexture(GL_TEXTURE_2D, *texture);
  // Rows have no padding, whatever their width.
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
  throw_if(number >= monitors.size(), "monitor {} does not exist; {} connected, numbered from 0",
           monitor, monitors.size());

  return monitors[number].refresh_hz > 0 ? monitors[number].refresh_hz : usual_hz;
}

/// Whether a gamma table was set; a monitor without one leaves grey levels unchanged.
bool make_gamma_table_the_identity(int monitor) {
  int count = 0;
  GLFWmonitor* const chosen = glfwGetMonitors(&count)[monitor];
  const GLFWgammaramp* const ramp = glfwGetGammaRamp(chosen);
  if (ramp == nullptr || ramp->size < 2) return false;
  glfwSetGamma(chosen, 1);  // glfwTerminate restores the original table
  return true;
}

}  // namespace

MonitorSink::MonitorSink(const opengl::WindowSystem& system, int monitor)
    : monitor_(monitor),
      refresh_hz_(refresh_hz_of(system, monitor)),
      window_(system, {.title = "slipstream projector", .fills_monitor = monitor}),
      has_gamma_table_(make_gamma_table_the_identity(monitor)),
      program_({.vertex = vertex_shader, .fragment = fragment_shader}),
      vertex_array_(opengl::make_vertex_array()),
      size_(window_.framebuffer_size()) {
  glfwSetInputMode(window_.get(), GLFW_CURSOR, GLFW_CURSOR_HIDDEN);

  glfwSetKeyCallback(window_.get(), [](GLFWwindow* window, int key, int, int action, int) {
    if (key == GLFW_KEY_ESCAPE && action == GLFW_PRESS) glfwSetWindowShouldClose(window, GLFW_TRUE);
  });

  // Wait for the refresh, and leave grey levels as they are.
  glfwSwapInterval(1);
  glDisable(GL_DITHER);
  glDisable(GL_FRAMEBUFFER_SRGB);
}

MonitorSink::~MonitorSink() {
  glfwMakeContextCurrent(window_.get());
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
  glfwMakeContextCurrent(window_.get());

  textures_.clear();
  for (const Image<Pixel>& pattern : patterns) textures_.push_back(texture_of(pattern));
  glfwMakeContextCurrent(nullptr);  // another thread may show them
}

void MonitorSink::show(std::size_t n) {
  draw(n);
  glfwSwapBuffers(window_.get());
  glFinish();
  glfwMakeContextCurrent(nullptr);
  ++shown_;
}

void MonitorSink::draw(std::size_t n) const {
  glfwMakeContextCurrent(window_.get());
  glViewport(0, 0, size_.width, size_.height);

  program_.use();
  glUniform1i(program_.uniform("pattern"), 0);
  glUniform1i(program_.uniform("height"), size_.height);

  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, *textures_.at(n));
  glBindVertexArray(*vertex_array_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
}

std::string MonitorSink::state() const {
  return has_gamma_table() ? "" : "the monitor has no gamma table to set";
}

bool MonitorSink::closed() const {
  glfwPollEvents();
  return glfwWindowShouldClose(window_.get()) == GLFW_TRUE || opengl::desktop_is_gone();
}

ProjectionReport project_patterns(PatternSink& sink, std::size_t count,
                                  const ProjectionSettings& settings) {
  if (count == 0) throw Error("no pattern to show; expected at least one");
  throw_if(settings.hold < 1, "a pattern cannot stay for {} refreshes; expected 1 or more",
           settings.hold);
  throw_if(!(settings.refresh_hz > 0), "projector refresh rate {} Hz; expected a positive rate",
           settings.refresh_hz);

  using Clock = std::chrono::steady_clock;
  const auto refresh = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(1 / settings.refresh_hz));

  ProjectionReport report;
  Clock::time_point first, last;
  std::uint64_t unpaced = 0;
  bool is_late = false;

  // Refreshes are counted one by one: a monitor's reported rate is rounded.
  for (int held = settings.hold; !settings.ends || !settings.ends(); ++held) {
    const bool is_next = held == settings.hold, started = report.refreshes++ > 0;
    const std::uint64_t sequence = report.shown - (is_next ? 0 : 1);
    const auto n = static_cast<std::size_t>(sequence % count);

    // show() waits for the next refresh if the driver does, so start half a refresh early.
    const Clock::time_point due = last + refresh;
    if (started) std::this_thread::sleep_until(due - refresh / 2);
    sink.show(n);

    // A return before the refresh was due means that the driver did not wait: the clock paces then.
    const Clock::time_point now = Clock::now();
    const bool waited = !started || now > due - refresh / 4;
    is_late |= started && now > due + refresh / 2;
    unpaced += waited ? 0 : 1;
    last = waited ? now : due;

    // Report once for each pattern, at its first refresh.
    if (!is_next) continue;
    held = 0;
    if (report.shown++ == 0) first = last;
    if (std::exchange(is_late, false)) ++report.late;
    report.seconds = std::chrono::duration<double>(last - first).count();
    if (settings.on_swap) settings.on_swap({sequence, static_cast<int>(n), last, report.seconds});
  }

  // The driver waited if most refreshes came no sooner than they were due.
  report.waits_for_refresh = 2 * unpaced <= report.refreshes;
  return report;
}

int refreshes_for(std::optional<double> rate, std::optional<int> hold, double refresh_hz) {
  if (rate && hold) throw Error("`rate` and `hold` exclude each other");

  const int held = hold.value_or(1);
  throw_if(held < 1, "`hold {}` is out of range; 1 or more refreshes", held);
  if (!rate) return held;
  throw_if(refresh_hz <= 0, "`rate {}`: the monitor's refresh rate is unknown; use `hold`", *rate);

  const double wanted = *rate > 0 ? refresh_hz / *rate : 0;
  const double whole = std::round(wanted);
  throw_if(
      !(whole >= 1) || std::abs(wanted - whole) > 0.02 * whole || whole > 1e6,
      "{:g} patterns per second: not the monitor's {:g} Hz divided by a whole number; use {:g} "
      "or {:g}",
      *rate, refresh_hz, refresh_hz, refresh_hz / 2);

  return static_cast<int>(whole);
}

}  // namespace slipstream::monitor
