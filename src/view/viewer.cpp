#include "slipstream/viewer.h"

#include <algorithm>

#include <GLFW/glfw3.h>
#include <epoxy/gl.h>
#include <fmt/format.h>
#include <imgui.h>

#include "frames/pattern_windows.h"
#include "slipstream/live_pipeline.h"
#include "view/cloud_screen.h"
#include "view/gui.h"
#include "view/opengl.h"

namespace slipstream::view {
namespace {

ShownCloud reconstructed(const std::shared_ptr<const StillScan>& scan, const EngineSetup& setup) {
  const auto made = std::make_shared<std::pair<Cloud, std::shared_ptr<const StillScan>>>();

  made->second = scan;
  Engine(setup).cloud(scan->frames, made->first);
  if (made->first.z.size() == scan->colour.size()) made->first.colour = scan->colour;

  return {
      .cloud = {made, &made->first}, .frames = scan->frames.views(), .findings = scan->findings};
}

/// The scan that is shown, and how it was reconstructed.
struct ShownScan {
  std::shared_ptr<const StillScan> scan;
  EngineSetup setup;
  ShownCloud shown = reconstructed(scan, setup);
};

using Gammas = decltype(ViewSource::gammas);

Gammas gammas_beside(const std::optional<MeasuredResponse>& initial) {
  Gammas choices{{"initial", initial}, {"none", std::nullopt}};

  for (const double gamma : {1.4, 1.8, 2.0, 2.2, 2.4}) {
    choices.emplace_back(fmt::format("{:g}", gamma), MeasuredResponse{PowerLaw{gamma}, gamma});
  }

  return choices;
}

/// Keeps the shown cloud and its frames out of their pools.
ShownCloud shown_cloud(const Pooled<LiveCloud>& cloud) {
  if (!cloud) return {};

  const auto share = std::make_shared<const Pooled<LiveCloud>>(cloud);
  return {.cloud = {share, &cloud->points()},
          .frames = views_of(cloud->frames),
          .sequence = cloud->sequence,
          .captured = cloud->newest.host_time};
}

using Clock = std::chrono::steady_clock;

/// Window events since the last picture; without events the picture stays.
struct WindowEvents {
  Clock::time_point last = Clock::now();
  std::vector<int> keys;
  std::string dropped;  ///< path of a file dropped on the window
};

WindowEvents& touch(GLFWwindow* window) {
  auto& events = *static_cast<WindowEvents*>(glfwGetWindowUserPointer(window));

  events.last = Clock::now();
  return events;
}

/// Dear ImGui chains callbacks that are set before it starts.
void listen(GLFWwindow* window, WindowEvents& events) {
  glfwSetWindowUserPointer(window, &events);

  glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) { touch(w); });
  glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) { touch(w); });
  glfwSetWindowContentScaleCallback(window, [](GLFWwindow* w, float, float) { touch(w); });
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double, double) { touch(w); });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int, int, int) { touch(w); });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double) { touch(w); });

  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    if (WindowEvents& noted = touch(w); count > 0) noted.dropped = paths[0];
  });
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) {
    if (WindowEvents& noted = touch(w); action == GLFW_PRESS) noted.keys.push_back(key);
  });
}

/// Schedules pictures: immediately after an event or a new cloud, otherwise every quarter of a
/// second, with pauses.
class Pace {
 public:
  /// Whether the next picture may start.
  [[nodiscard]] bool rested() const { return Clock::now() >= next_; }

  /// Whether to redraw without a new cloud.
  [[nodiscard]] bool outdated(Clock::time_point last_event) const {
    using std::chrono::milliseconds;
    const auto now = Clock::now();
    return now - last_event < milliseconds(300) || now - drawn_ > milliseconds(250);
  }

  /// Draws and pauses: for the rest of the frame time, and at least as long as drawing took, so
  /// that software rendering leaves half of the processor to the pipeline.
  void draw(const std::function<void()>& picture) {
    const auto start = Clock::now();
    picture();
    glFinish();
    drawn_ = Clock::now();
    const std::chrono::duration<double> took = drawn_ - start;
    const std::chrono::duration<double> rest(std::max(least - took.count(), took.count()));
    next_ = drawn_ + std::chrono::duration_cast<Clock::duration>(rest);
  }

  [[nodiscard]] double seconds_to_next() const {
    return std::max(std::chrono::duration<double>(next_ - Clock::now()).count(), 0.0);
  }

 private:
  static constexpr double least = 1.0 / 60;  ///< s per picture
  Clock::time_point drawn_{}, next_{};
};

}  // namespace

ViewSource still_source(Cloud cloud, std::optional<Uncertainty> uncertainty) {
  ShownCloud shown{.cloud = std::make_shared<const Cloud>(std::move(cloud))};
  if (uncertainty) shown.uncertainty = std::make_shared<const Uncertainty>(*std::move(uncertainty));

  return {.newest = [shown] { return shown; }};
}

ViewSource still_source(StillScan scan, const EngineSetup& setup,
                        std::function<StillScan(std::size_t)> scan_at) {
  const auto kept = std::make_shared<const StillScan>(std::move(scan));
  const auto shown = std::make_shared<ShownScan>(ShownScan{kept, setup});

  ViewSource source{.newest = [shown] { return shown->shown; },
                    .setup = setup,
                    .change =
                        [shown](const EngineSetup& other) {
                          *shown = ShownScan{shown->scan, other};
                        }};

  if (scan_at) {
    source.show_scan = [shown, scan_at = std::move(scan_at)](std::size_t number) {
      const auto read = std::make_shared<const StillScan>(scan_at(number));
      *shown = ShownScan{read, shown->setup};
    };
  }

  return source;
}

ViewSource live_source(LivePipeline& pipeline, const EngineSetup& setup, bool patterns_can_change) {
  std::vector<std::pair<std::string, Strategy>> strategies;
  for (const Strategy& choice : strategies_beside(setup.sequence.strategy)) {
    if (patterns_can_change || strategies.empty())
      strategies.emplace_back(label_of(choice), choice);
  }
  return {.newest = [&pipeline] { return shown_cloud(pipeline.newest()); },
          .shown = [&pipeline](const ShownCloud& cloud) { pipeline.shown(cloud.captured); },
          .statistics = [&pipeline] { return pipeline.statistics(); },
          .setup = setup,
          .change = [&pipeline](const EngineSetup& other) { pipeline.change(other); },
          .strategies = strategies,
          .gammas = gammas_beside(setup.scanner.photometry.response)};
}

std::optional<Image<Colour>> run_viewer(ViewSource source, const ViewerSettings& settings) {
  const opengl::WindowSystem system;
  const opengl::Window window(system, {.title = source.title, .size = settings.size});
  glfwSwapInterval(1);

  // Callbacks must be set before Dear ImGui starts.
  WindowEvents events;
  listen(window.get(), events);

  ViewSource shown = std::move(source);
  std::optional<CloudScreen> clouds(std::in_place, shown, settings.view, &window);
  Pace pace;
  std::optional<Image<Colour>> last;
  bool open = true;

  while (open) {
    // 1. Another source: its screen replaces the present one.
    if (const auto begin = clouds->take_next()) {
      const ViewSettings kept = clouds->state().view;
      clouds.reset();  // there is one at a time
      shown = {};      // frees its camera
      shown = begin();

      glfwMakeContextCurrent(window.get());  // a projector's window may have come or gone
      glfwSetWindowTitle(window.get(), shown.title.c_str());

      clouds.emplace(shown, kept, &window);
    }

    // 2. Events since the last picture, and whether to close.
    for (const int key : std::exchange(events.keys, {})) clouds->press(key);
    if (!events.dropped.empty()) clouds->open(std::exchange(events.dropped, {}));
    open = glfwWindowShouldClose(window.get()) == GLFW_FALSE && !clouds->closed() &&
           !(settings.ends && settings.ends());

    // 3. Draw, if there is something new to see; the last picture always. Without the desktop the
    // screen's size is not known.
    const Screen screen = screen_of(window);
    if (opengl::desktop_is_gone()) break;
    const bool visible = screen.framebuffer.width > 0 && screen.framebuffer.height > 0;
    if (visible && (!open || pace.rested())) {
      const bool fresh = clouds->take_newest();
      if (!open || fresh || pace.outdated(events.last)) {
        pace.draw([&] {
          clouds->draw(screen);
          if (!open && settings.keep_last) last = opengl::read_pixels(screen.framebuffer);
        });

        glfwSwapBuffers(window.get());
        clouds->tell_shown();
      }
    }

    // 4. Sleep until the next picture (4 ms or longer) or an event.
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

  // Dear ImGui knows widget heights only after drawing them.
  for (int pass = 0; pass < 3; ++pass) clouds.draw({.window = size, .framebuffer = size});

  return opengl::read_pixels(size);
}

}  // namespace slipstream::view
