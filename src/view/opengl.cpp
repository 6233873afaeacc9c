#include "view/opengl.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <filesystem>

#ifdef __linux__
#include <dlfcn.h>
#endif

#include <GLFW/glfw3.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include "base/system_failure.h"
#include "base/throw_if-inl.h"

namespace slipstream::opengl {
namespace {

template <class Remove>
Resource held(GLuint number, const Remove& remove) {
  return {new GLuint(number), [remove](const GLuint* old) {
            remove(*old);
            delete old;
          }};
}

/// By reference: epoxy declares OpenGL's functions as variables.
template <auto& generate, auto& remove>
Resource make() {
  GLuint number = 0;
  generate(1, &number);
  return held(number, [](GLuint old) { remove(1, &old); });
}

/// The info log of a shader or a program, by its query functions.
template <class Query, class Log>
void require_good(GLuint number, GLenum status, const Query& query, const Log& log,
                  const std::string& failure) {
  GLint good = GL_FALSE;
  query(number, status, &good);
  if (good == GL_TRUE) return;

  std::string words(2048, '\0');
  GLsizei length = 0;
  log(number, static_cast<GLsizei>(words.size()), &length, words.data());
  words.resize(std::max(length, 0));

  throw WorldError(fmt::format("{}: {}", failure, words));
}

Resource compile(GLenum kind, const char* source, const std::string& file) {
  Resource shader = held(glCreateShader(kind), [](GLuint old) { glDeleteShader(old); });

  glShaderSource(*shader, 1, &source, nullptr);
  glCompileShader(*shader);

  require_good(*shader, GL_COMPILE_STATUS, glGetShaderiv, glGetShaderInfoLog,
               "OpenGL does not compile a shader of " + file);

  return shader;
}

int window_systems = 0;  // GLFW has one, which ends with the last

std::atomic<bool> desktop_gone = false;

/// When the X server goes, Xlib would end the program with exit(1), from 1.7 on unless a handler of
/// the display returns. All calls then return without effect. Under Wayland GLFW closes the
/// windows.
void outlive_x_server() {
#ifdef __linux__
  // GLFW may load Xlib by itself, so the functions are looked up among the loaded libraries.
  void* const xlib = ::dlopen("libX11.so.6", RTLD_LAZY | RTLD_NOLOAD);
  if (xlib == nullptr) return;

  using GetDisplay = void* (*)();
  using SetHandler = void* (*)(int (*)(void*));
  using SetExit = void (*)(void*, void (*)(void*, void*), void*);
  const auto get_display = reinterpret_cast<GetDisplay>(::dlsym(RTLD_DEFAULT, "glfwGetX11Display"));
  const auto set_handler = reinterpret_cast<SetHandler>(::dlsym(xlib, "XSetIOErrorHandler"));
  const auto set_exit = reinterpret_cast<SetExit>(::dlsym(xlib, "XSetIOErrorExitHandler"));

  void* const display = get_display != nullptr ? get_display() : nullptr;
  if (display == nullptr || set_handler == nullptr || set_exit == nullptr) return;

  set_handler([](void*) { return 0; });  // Xlib's own prints a line
  set_exit(
      display, [](void*, void*) { desktop_gone = true; }, nullptr);
#endif
}

/// Without the desktop GLFW would wait for its answers; only the context can be let go.
void destroy_window(GLFWwindow* window) {
  if (desktop_gone) {
    glfwMakeContextCurrent(nullptr);
  } else {
    glfwDestroyWindow(window);
  }
}

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

/// The desktop's connection and the drivers of graphics need about half of these; some crash if
/// they cannot open a file.
constexpr std::size_t descriptors_of_drivers = 32;

/// An EGL display with a current surfaceless context; null if unavailable.
std::shared_ptr<void> egl_context() {
  if (!epoxy_has_egl()) return nullptr;

  // 1. A display: Mesa needs no desktop for this one.
  const EGLDisplay display =
      epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")
          ? eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)
          : eglGetDisplay(EGL_DEFAULT_DISPLAY);
  if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) == EGL_FALSE) {
    return nullptr;
  }

  const std::shared_ptr<void> egl(display, [](EGLDisplay old) {
    eglMakeCurrent(old, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglTerminate(old);  // with its context
  });
  // Without a desktop EGL only has configurations for pixel buffers; no buffer is created.
  constexpr std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                         EGL_OPENGL_BIT, EGL_NONE};
  constexpr EGLint profile = EGL_CONTEXT_OPENGL_PROFILE_MASK;
  constexpr EGLint core = EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT;
  constexpr std::array<EGLint, 7> version{
      EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3, profile, core, EGL_NONE};

  // 2. A configuration that draws OpenGL.
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE ||
      eglChooseConfig(display, wanted.data(), &config, 1, &count) == EGL_FALSE || count == 0) {
    return nullptr;
  }

  // 3. An OpenGL 3.3 core context without a surface.
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, version.data());
  const bool current = context != EGL_NO_CONTEXT &&
                       eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_TRUE;

  return current ? egl : nullptr;
}

struct HiddenWindow {
  WindowSystem system;
  Window window{system, {.size = {64, 64}, .visible = false}};
};

}  // namespace

Resource make_buffer() {
  return make<glGenBuffers, glDeleteBuffers>();
}

Resource make_vertex_array() {
  return make<glGenVertexArrays, glDeleteVertexArrays>();
}

Resource make_texture() {
  return make<glGenTextures, glDeleteTextures>();
}

ShaderProgram::ShaderProgram(const ShaderSources& sources, const char* path)
    : program_(held(glCreateProgram(), [](GLuint old) { glDeleteProgram(old); })) {
  const std::string file = std::filesystem::path(path).filename();
  const auto attach = [&](GLenum kind, const char* source) {
    if (source == nullptr) return;
    glAttachShader(*program_, *compile(kind, source, file));
  };

  attach(GL_VERTEX_SHADER, sources.vertex);
  attach(GL_GEOMETRY_SHADER, sources.geometry);
  attach(GL_FRAGMENT_SHADER, sources.fragment);

  glLinkProgram(*program_);
  require_good(*program_, GL_LINK_STATUS, glGetProgramiv, glGetProgramInfoLog,
               "OpenGL does not link the shaders of " + file);
}

void ShaderProgram::use() const {
  glUseProgram(*program_);
}

int ShaderProgram::uniform(const char* name) const {
  return glGetUniformLocation(*program_, name);
}

void PictureTexture::upload(const Image<Colour>& picture) {
  glBindTexture(GL_TEXTURE_2D, *texture_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);

  // A picture of the same size keeps the texture's memory.
  if (picture.size() == size_) {
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size_.width, size_.height, GL_RGB, GL_UNSIGNED_BYTE,
                    picture.begin());
    return;
  }

  size_ = picture.size();
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, size_.width, size_.height, 0, GL_RGB, GL_UNSIGNED_BYTE,
               picture.begin());

  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

RenderTarget::RenderTarget(Size size)
    : size_(size),
      colour_(make<glGenRenderbuffers, glDeleteRenderbuffers>()),
      depth_(make<glGenRenderbuffers, glDeleteRenderbuffers>()),
      framebuffer_(make<glGenFramebuffers, glDeleteFramebuffers>()) {
  GLint longest = 0;
  glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &longest);

  throw_if(std::max(size.width, size.height) > longest || std::min(size.width, size.height) < 1,
           "cannot draw a picture of {}x{}; expected 1 to {} pixels per side", size.width,
           size.height, longest);

  const auto allocate = [&](const Resource& buffer, GLenum format) {
    glBindRenderbuffer(GL_RENDERBUFFER, *buffer);
    glRenderbufferStorage(GL_RENDERBUFFER, format, size.width, size.height);
  };

  allocate(colour_, GL_RGBA8);
  allocate(depth_, GL_DEPTH_COMPONENT24);

  glBindFramebuffer(GL_FRAMEBUFFER, *framebuffer_);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, *colour_);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, *depth_);

  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw WorldError(
        fmt::format("OpenGL has no memory for a picture of {}x{}", size.width, size.height));
  }
}

void RenderTarget::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, *framebuffer_);
  glViewport(0, 0, size_.width, size_.height);
}

Image<Colour> read_pixels(Size size) {
  static_assert(sizeof(Colour) == 3);
  Image<Colour> upside_down(size), picture(size);

  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, size.width, size.height, GL_RGB, GL_UNSIGNED_BYTE, upside_down.row(0));

  // OpenGL's first row is at the bottom.
  for (int row = 0; row < size.height; ++row) {
    std::copy_n(upside_down.row(size.height - 1 - row), size.width, picture.row(row));
  }

  return picture;
}

bool desktop_is_gone() {
  return desktop_gone;
}

WindowSystem::WindowSystem() {
  if (desktop_gone) throw WorldError("no desktop to open a window on: it has ended");
  require_descriptors(descriptors_of_drivers, "a window");

#ifdef GLFW_PLATFORM  // from GLFW 3.4
  // Wayland does not let a window choose its place; without a desktop its library prints an error.
  if (std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") == nullptr)
    glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif

  if (glfwInit() != GLFW_TRUE) {
    throw NoDesktop(fmt::format("no desktop to open a window on: {}", last_words()));
  }

  ++window_systems;
  outlive_x_server();
}

WindowSystem::~WindowSystem() {
  if (--window_systems == 0 && !desktop_gone) glfwTerminate();
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

Window::Window(const WindowSystem& /*system*/, const WindowSettings& settings)
    : window_(nullptr, destroy_window) {
  // 1. An OpenGL 3.3 core context.
  glfwDefaultWindowHints();
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_VISIBLE, settings.visible ? GLFW_TRUE : GLFW_FALSE);

  // 2. The monitor to fill, if any.
  Size size = settings.size;
  GLFWmonitor* monitor = nullptr;
  if (settings.fills_monitor >= 0) {
    const std::vector<GLFWmonitor*> monitors = connected_monitors();
    const auto number = static_cast<std::size_t>(settings.fills_monitor);
    throw_if(number >= monitors.size(),
             "monitor {} does not exist; monitors are numbered from 0, and {} {} connected", number,
             monitors.size(), monitors.size() == 1 ? "is" : "are");
    monitor = monitors[number];

    // The monitor's own mode, so that the desktop does not switch modes or scale pixels.
    const GLFWvidmode* const mode = glfwGetVideoMode(monitor);
    if (mode == nullptr) throw WorldError(fmt::format("monitor {}: {}", number, last_words()));

    size = {mode->width, mode->height};
    glfwWindowHint(GLFW_REFRESH_RATE, mode->refreshRate);
    glfwWindowHint(GLFW_AUTO_ICONIFY, GLFW_FALSE);
  } else if (settings.visible) {
    // As much larger as the desktop's text.
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  }

  // 3. Open the window.
  window_.reset(
      glfwCreateWindow(size.width, size.height, settings.title.c_str(), monitor, nullptr));
  if (!window_) throw WorldError(fmt::format("no OpenGL 3.3 window: {}", last_words()));
  glfwMakeContextCurrent(get());
}

Size Window::framebuffer_size() const {
  Size size;
  glfwGetFramebufferSize(get(), &size.width, &size.height);
  return size;
}

OffScreenContext::OffScreenContext() {
  require_descriptors(descriptors_of_drivers, "drawing");
  context_ = egl_context();
  if (context_) return;
  try {
    context_ = std::make_shared<HiddenWindow>();
  } catch (const WorldError& error) {
    throw WorldError(fmt::format("cannot draw: EGL offers no OpenGL 3.3 without a surface, and {}",
                                 error.what()));
  }
}

}  // namespace slipstream::opengl
