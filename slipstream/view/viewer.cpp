#include "slipstream/view/viewer.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include <GLFW/glfw3.h>
#include <epoxy/gl.h>

#include "slipstream/view/cloud_screen.h"
#include "slipstream/view/opengl.h"
#include "slipstream/view/window.h"

namespace slipstream::view {
namespace {

using Clock = std::chrono::steady_clock;

/// When something last happened to the window, so that it is not drawn again for nothing; and the
/// keys, which may be pressed and let go of between two pictures.
struct WindowEvents {
  Clock::time_point last = Clock::now();
  std::vector<int> keys;
  std::string dropped;  ///< path of a file that was dropped on the window
};

WindowEvents& events_of(GLFWwindow* window) {
  return *static_cast<WindowEvents*>(glfwGetWindowUserPointer(window));
}

void touch(GLFWwindow* window) {
  events_of(window).last = Clock::now();
}

/// Dear ImGui calls on what is set before it starts.
void listen(GLFWwindow* window, WindowEvents& events) {
  glfwSetWindowUserPointer(window, &events);
  glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) { touch(w); });
  glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) { touch(w); });
  glfwSetWindowContentScaleCallback(window, [](GLFWwindow* w, float, float) { touch(w); });
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double, double) { touch(w); });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int, int, int) { touch(w); });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double) { touch(w); });
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    touch(w);
    if (count > 0) events_of(w).dropped = paths[0];
  });
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) {
    touch(w);
    if (action == GLFW_PRESS) events_of(w).keys.push_back(key);
  });
}

/// When to draw: at once what an event or a cloud changed, and what is a quarter of a second old
/// for its numbers, but never without a rest.
class Pace {
 public:
  explicit Pace(double most_per_second) : least_(1 / std::max(most_per_second, 1.0)) {}

  /// Whether the next picture may begin.
  [[nodiscard]] bool rested() const { return Clock::now() >= next_; }
  /// Whether it is wanted even though there is no new cloud.
  [[nodiscard]] bool outdated(Clock::time_point last_event) const {
    using std::chrono::milliseconds;
    const auto now = Clock::now();
    return now - last_event < milliseconds(300) || now - drawn_ > milliseconds(250);
  }
  /// Draws and rests: for what is left of the picture's share, and at least as long as it took, so
  /// that drawing in software leaves the processor to the pipeline half of the time.
  void draw(const std::function<void()>& picture) {
    const auto start = Clock::now();
    picture();
    glFinish();
    drawn_ = Clock::now();
    const std::chrono::duration<double> took = drawn_ - start;
    const std::chrono::duration<double> rest(std::max(least_ - took.count(), took.count()));
    next_ = drawn_ + std::chrono::duration_cast<Clock::duration>(rest);
  }
  [[nodiscard]] double seconds_to_next() const {
    return std::max(std::chrono::duration<double>(next_ - Clock::now()).count(), 0.0);
  }

 private:
  double least_;
  Clock::time_point drawn_{};
  Clock::time_point next_{};
};

}  // namespace

std::optional<Image<Colour>> run_viewer(const ViewSource& source, const ViewerSettings& settings) {
  const opengl::WindowSystem system;
  const opengl::Window window(system, {.title = source.title, .size = settings.size});
  window.wait_for_refresh(true);
  WindowEvents events;
  listen(window.get(), events);
  ViewSource shown = source;
  std::optional<CloudScreen> clouds(std::in_place, shown, settings.view, &window);
  Pace pace(settings.most_per_second);
  std::optional<Image<Colour>> last;
  bool open = true;
  while (open) {
    for (const int key : std::exchange(events.keys, {})) clouds->press(key);
    if (!events.dropped.empty()) clouds->open(std::exchange(events.dropped, {}));
    if (auto opened = clouds->take_opened()) {
      const ViewSettings kept = clouds->state().view;
      clouds.reset();  // there is one at a time
      shown = std::move(*opened);
      glfwSetWindowTitle(window.get(), shown.title.c_str());
      clouds.emplace(shown, kept, &window);
    }
    open = !window.should_close() && !clouds->closed() && !(settings.ends && settings.ends());
    const Screen screen = screen_of(window);
    const bool visible = screen.framebuffer.width > 0 && screen.framebuffer.height > 0;
    if (visible && (!open || pace.rested())) {
      const bool fresh = clouds->take_newest();
      if (!open || fresh || pace.outdated(events.last)) {
        pace.draw([&] {
          clouds->draw(screen);
          if (!open && settings.keep_last) last = opengl::read_pixels(screen.framebuffer);
        });
        window.swap();
        clouds->tell_shown();
      }
    }
    if (open) glfwWaitEventsTimeout(std::max(pace.seconds_to_next(), 0.004));
  }
  return last;
}

Image<Colour> render_screen(const ViewSource& source, const ViewSettings& settings, Size size,
                            Surround surround) {
  const opengl::OffScreenContext context;
  const opengl::RenderTarget target(size);
  target.bind();
  CloudScreen clouds(source, settings, nullptr);
  clouds.state().shown = surround == Surround::panel;
  clouds.take_newest();
  // Dear ImGui knows the heights of its own widgets only after it has drawn them.
  for (int pass = 0; pass < 3; ++pass) clouds.draw({.window = size, .framebuffer = size});
  return opengl::read_pixels(size);
}

}  // namespace slipstream::view
