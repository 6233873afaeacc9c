#include "slipstream/devices/monitor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <thread>
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

using Table = std::vector<unsigned short>;

void set_table(GLFWmonitor* monitor, Table& red, Table& green, Table& blue) {
  GLFWgammaramp ramp{red.data(), green.data(), blue.data(), static_cast<unsigned>(red.size())};
  glfwSetGammaRamp(monitor, &ramp);
}

/// GLFW lets go of what it knew of a monitor that was unplugged.
bool is_connected(const GLFWmonitor* monitor) {
  int count = 0;
  GLFWmonitor** const monitors = glfwGetMonitors(&count);
  return std::find(monitors, monitors + count, monitor) != monitors + count;
}

using Clock = std::chrono::steady_clock;

Clock::duration from_seconds(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// Keeps each pattern on for its refreshes, which are counted one by one: the rate that a monitor
/// tells is rounded.
class Pace {
 public:
  Pace(PatternSink& sink, double refresh_hz, int hold)
      : sink_(sink), refresh_(from_seconds(1 / refresh_hz)), hold_(hold) {}

  /// Puts pattern n on when the one before has had its time; returns when that was, or nothing
  /// where it is `over` before.
  template <class Over>
  std::optional<Clock::time_point> next(std::size_t n, const Over& over) {
    late_ = false;
    for (int again = 1; started_ && again < hold_; ++again) {
      if (over()) return std::nullopt;
      refresh(shown_);
    }
    refresh(n);
    started_ = true;
    shown_ = n;
    return last_;
  }
  [[nodiscard]] bool late() const { return late_; }
  [[nodiscard]] std::uint64_t refreshes() const { return refreshes_; }
  /// Whether showing waits for the monitor.
  [[nodiscard]] bool waits() const { return 2 * unpaced_ <= refreshes_; }

 private:
  /// Showing waits for the next refresh, so it is begun half a refresh before. Drivers without a
  /// screen do not wait: then the clock alone says when.
  void refresh(std::size_t n) {
    const Clock::time_point due = last_ + refresh_;
    if (started_) std::this_thread::sleep_until(due - refresh_ / 2);
    sink_.show(n);
    const auto now = Clock::now();
    const bool waited = !started_ || now > due - refresh_ / 4;
    late_ |= started_ && now > due + refresh_ / 2;
    unpaced_ += waited ? 0 : 1;
    last_ = waited ? now : due;
    ++refreshes_;
  }

  PatternSink& sink_;
  Clock::duration refresh_;
  int hold_;
  bool started_ = false, late_ = false;
  std::uint64_t refreshes_ = 0, unpaced_ = 0;
  std::size_t shown_ = 0;
  Clock::time_point last_{};
};

}  // namespace

IdentityGammaTable::IdentityGammaTable(const opengl::WindowSystem& system, int monitor) {
  static_cast<void>(system);
  int count = 0;
  GLFWmonitor** const monitors = glfwGetMonitors(&count);
  if (monitor < 0 || monitor >= count) return;
  monitor_ = monitors[monitor];
  const GLFWgammaramp* const ramp = glfwGetGammaRamp(monitor_);
  if (ramp == nullptr || ramp->size < 2) return;
  red_.assign(ramp->red, ramp->red + ramp->size);
  green_.assign(ramp->green, ramp->green + ramp->size);
  blue_.assign(ramp->blue, ramp->blue + ramp->size);
  Table identity(ramp->size);
  for (std::size_t i = 0; i < identity.size(); ++i) {
    identity[i] = static_cast<unsigned short>(65535 * i / (identity.size() - 1));
  }
  Table green = identity, blue = identity;
  set_table(monitor_, identity, green, blue);
}

IdentityGammaTable::~IdentityGammaTable() {
  if (exists() && is_connected(monitor_)) set_table(monitor_, red_, green_, blue_);
}

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

void SwapLog::add(const PatternSwap& swap) {
  if (!first_) first_ = swap.time;
  text_ += fmt::format("{},{},{:.6f}\n", swap.sequence, swap.pattern,
                       std::chrono::duration<double>(swap.time - *first_).count());
}

ProjectionReport project_patterns(PatternSink& sink, std::size_t count,
                                  const ProjectionSettings& settings) {
  if (count == 0) throw Error("no pattern to be shown; one or more are wanted");
  if (settings.hold < 1) {
    throw Error(fmt::format("a pattern cannot stay for {} refreshes; 1 or more", settings.hold));
  }
  if (!(settings.refresh_hz > 0)) {
    throw Error(fmt::format("a projector of {} Hz shows nothing; above 0", settings.refresh_hz));
  }
  ProjectionReport report;
  Pace pace(sink, settings.refresh_hz, settings.hold);
  Clock::time_point first;
  const auto over = [&] { return settings.ends && settings.ends(); };
  while (!over()) {
    const auto n = static_cast<std::size_t>(report.shown % count);
    const std::optional<Clock::time_point> time = pace.next(n, over);
    if (!time) break;
    const PatternSwap swap{report.shown, static_cast<int>(n), *time};
    if (report.shown == 0) first = swap.time;
    ++report.shown;
    if (pace.late()) ++report.late;
    report.seconds = std::chrono::duration<double>(swap.time - first).count();
    if (settings.on_swap) settings.on_swap(swap);
  }
  report.refreshes = pace.refreshes();
  report.waits_for_refresh = pace.waits();
  return report;
}

int refreshes_for(std::optional<double> rate, std::optional<int> hold, double refresh_hz) {
  if (rate && hold) throw Error("--rate and --hold exclude each other");
  if (hold && *hold < 1) {
    throw Error(fmt::format("--hold {} is out of range; 1 or more refreshes", *hold));
  }
  if (!rate) return hold.value_or(1);
  if (refresh_hz <= 0) {
    throw Error(fmt::format(
        "--rate {}: the monitor does not say how often it refreshes; use --hold", *rate));
  }
  const double wanted = *rate > 0 ? refresh_hz / *rate : 0;
  const double whole = std::round(wanted);
  if (!(whole >= 1) || std::abs(wanted - whole) > 0.02 * whole || whole > 1e6) {
    throw Error(
        fmt::format("{:g} patterns per second are not {:g} Hz, the monitor's, divided by a "
                    "whole number; as {:g} or {:g}",
                    *rate, refresh_hz, refresh_hz, refresh_hz / 2));
  }
  return static_cast<int>(whole);
}

}  // namespace slipstream::monitor
