#include "slipstream/view/window.h"

#include <array>
#include <cstddef>

#include <GLFW/glfw3.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream::opengl {
namespace {

std::string last_words() {
  const char* words = nullptr;
  glfwGetError(&words);
  return words != nullptr ? words : "no reason given";
}

std::vector<GLFWmonitor*> connected_monitors() {
  int count = 0;
  GLFWmonitor** const first = glfwGetMonitors(&count);
  return {first, first + count};
}

EGLDisplay display_without_surface() {
  if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
    return eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  }
  return eglGetDisplay(EGL_DEFAULT_DISPLAY);
}

/// A display of EGL and its context, which is current without a surface.
struct Egl {
  explicit Egl(EGLDisplay of) : display(of) {}
  Egl(const Egl&) = delete;
  Egl& operator=(const Egl&) = delete;
  ~Egl() {
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    eglTerminate(display);
  }

  EGLDisplay display;
  EGLContext context = EGL_NO_CONTEXT;
};

/// Null where EGL has none.
std::shared_ptr<Egl> egl_context() {
  if (!epoxy_has_egl()) return nullptr;
  const EGLDisplay display = display_without_surface();
  if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) == EGL_FALSE) {
    return nullptr;
  }
  const auto egl = std::make_shared<Egl>(display);
  // Without a desktop there are configurations for pixel buffers only; none is made.
  constexpr std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                         EGL_OPENGL_BIT, EGL_NONE};
  constexpr std::array<EGLint, 7> version{EGL_CONTEXT_MAJOR_VERSION,
                                          3,
                                          EGL_CONTEXT_MINOR_VERSION,
                                          3,
                                          EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                          EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                          EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE ||
      eglChooseConfig(display, wanted.data(), &config, 1, &count) == EGL_FALSE || count == 0) {
    return nullptr;
  }
  egl->context = eglCreateContext(display, config, EGL_NO_CONTEXT, version.data());
  const bool current =
      egl->context != EGL_NO_CONTEXT &&
      eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl->context) == EGL_TRUE;
  return current ? egl : nullptr;
}

struct HiddenWindow {
  WindowSystem system;
  Window window{system, {.size = {64, 64}, .visible = false}};
};

}  // namespace

WindowSystem::WindowSystem() {
  if (glfwInit() != GLFW_TRUE) {
    throw WorldError(fmt::format("no desktop to open a window on: {}", last_words()));
  }
}

WindowSystem::~WindowSystem() {
  glfwTerminate();
}

std::vector<WindowSystem::Monitor> WindowSystem::monitors() const {
  std::vector<Monitor> monitors;
  for (GLFWmonitor* const monitor : connected_monitors()) {
    const GLFWvidmode* const mode = glfwGetVideoMode(monitor);
    if (mode == nullptr) continue;
    Monitor found{.name = glfwGetMonitorName(monitor),
                  .size = {mode->width, mode->height},
                  .refresh_hz = mode->refreshRate};
    glfwGetMonitorPos(monitor, &found.left, &found.top);
    monitors.push_back(found);
  }
  return monitors;
}

Window::Window(const WindowSystem& system, const WindowSettings& settings) {
  static_cast<void>(system);
  glfwDefaultWindowHints();
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_VISIBLE, settings.visible ? GLFW_TRUE : GLFW_FALSE);
  Size size = settings.size;
  GLFWmonitor* monitor = nullptr;
  if (settings.fills_monitor >= 0) {
    const std::vector<GLFWmonitor*> monitors = connected_monitors();
    const auto number = static_cast<std::size_t>(settings.fills_monitor);
    if (number >= monitors.size()) {
      throw Error(
          fmt::format("monitor {} is not there; monitors are numbered from 0, and {} {} "
                      "connected",
                      number, monitors.size(), monitors.size() == 1 ? "is" : "are"));
    }
    monitor = monitors[number];
    // Its own mode, so that the desktop changes nothing and no pixel is scaled.
    const GLFWvidmode* const mode = glfwGetVideoMode(monitor);
    if (mode == nullptr) throw WorldError(fmt::format("monitor {}: {}", number, last_words()));
    size = {mode->width, mode->height};
    glfwWindowHint(GLFW_REFRESH_RATE, mode->refreshRate);
    glfwWindowHint(GLFW_AUTO_ICONIFY, GLFW_FALSE);
  }
  window_.reset(
      glfwCreateWindow(size.width, size.height, settings.title.c_str(), monitor, nullptr));
  if (!window_) throw WorldError(fmt::format("no OpenGL 3.3 window: {}", last_words()));
  make_current();
}

void Window::Close::operator()(GLFWwindow* window) const {
  glfwDestroyWindow(window);
}

Size Window::size() const {
  Size size;
  glfwGetWindowSize(get(), &size.width, &size.height);
  return size;
}

Size Window::framebuffer_size() const {
  Size size;
  glfwGetFramebufferSize(get(), &size.width, &size.height);
  return size;
}

float Window::content_scale() const {
  float across = 1, down = 1;
  glfwGetWindowContentScale(get(), &across, &down);
  return across > 0 ? across : 1;
}

bool Window::should_close() const {
  return glfwWindowShouldClose(get()) == GLFW_TRUE;
}

void Window::make_current() const {
  glfwMakeContextCurrent(get());
}

void Window::swap() const {
  glfwSwapBuffers(get());
}

void Window::wait_for_refresh(bool wait) const {
  glfwSwapInterval(wait ? 1 : 0);
}

OffScreenContext::OffScreenContext() : context_(egl_context()) {
  if (context_) return;
  try {
    context_ = std::make_shared<HiddenWindow>();
  } catch (const WorldError& error) {
    throw WorldError(fmt::format("cannot draw: EGL gives no OpenGL 3.3 without a surface, and {}",
                                 error.what()));
  }
}

}  // namespace slipstream::opengl
