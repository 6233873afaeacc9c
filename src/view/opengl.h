#pragma once

#include <memory>
#include <source_location>
#include <string>
#include <vector>

#include "slipstream/error.h"
#include "slipstream/image.h"

struct GLFWwindow;

namespace slipstream::opengl {

/// Owns an OpenGL object name (buffer, texture, ...) of the context current at construction;
/// shared, deleted with its last owner, which must not outlive the context.
using Resource = std::shared_ptr<const unsigned>;

Resource make_buffer();
Resource make_vertex_array();
Resource make_texture();

/// GLSL 3.30 sources; the geometry shader is optional.
struct ShaderSources {
  const char* vertex = nullptr;
  const char* geometry = nullptr;
  const char* fragment = nullptr;
};

/// Shaders, compiled and linked.
class ShaderProgram {
 public:
  /// Throws WorldError with the driver's message and the sources' file if compiling fails.
  explicit ShaderProgram(const ShaderSources& sources,
                         const char* path = std::source_location::current().file_name());

  void use() const;
  /// Location for glUniform...; OpenGL ignores the location of an unknown name.
  [[nodiscard]] int uniform(const char* name) const;

 private:
  Resource program_;
};

/// A picture in graphics memory.
class PictureTexture {
 public:
  void upload(const Image<Colour>& picture);
  [[nodiscard]] unsigned number() const { return *texture_; }
  [[nodiscard]] Size size() const { return size_; }

 private:
  Resource texture_ = make_texture();
  Size size_;
};

/// A render target with depth.
class RenderTarget {
 public:
  /// Throws Error for a size out of range, WorldError if the driver refuses that size.
  explicit RenderTarget(Size size);

  /// Binds it: draws into all of it from now on.
  void bind() const;

 private:
  Size size_;
  Resource colour_, depth_, framebuffer_;
};

/// The bound framebuffer's picture, first row at the top.
Image<Colour> read_pixels(Size size);

/// There is no desktop to open a window on.
class NoDesktop : public WorldError {
 public:
  using WorldError::WorldError;
};

/// The connection to the desktop; at most one, in the main thread, outliving every Window.
class WindowSystem {
 public:
  /// Throws NoDesktop; WorldError once the desktop has ended.
  WindowSystem();
  WindowSystem(const WindowSystem&) = delete;
  WindowSystem& operator=(const WindowSystem&) = delete;
  ~WindowSystem();

  /// A screen, or a projector connected as one.
  struct Monitor {
    std::string name;
    Size size;  ///< pixels
    int left = 0, top = 0;
    int refresh_hz = 0;
  };
  /// The first is the desktop's primary monitor.
  [[nodiscard]] std::vector<Monitor> monitors() const;
};

/// Whether the desktop has ended while a window was open. It is no error: the window counts as
/// closed, calls on it have no effect, and no other can be opened.
bool desktop_is_gone();

struct WindowSettings {
  std::string title = "slipstream";
  Size size{1280, 800};    ///< inner size; the monitor's if fullscreen
  bool visible = true;     ///< false: for off-screen drawing
  int fills_monitor = -1;  ///< monitor to fill without a frame; below 0: an ordinary window
};

/// A window with an OpenGL 3.3 core context, made current at construction.
class Window {
 public:
  /// Throws Error for a missing monitor, WorldError if the desktop or its OpenGL cannot open a
  /// window.
  Window(const WindowSystem& system, const WindowSettings& settings);

  [[nodiscard]] GLFWwindow* get() const { return window_.get(); }
  [[nodiscard]] Size framebuffer_size() const;  ///< in pixels

 private:
  std::unique_ptr<GLFWwindow, void (*)(GLFWwindow*)> window_;
};

/// An OpenGL 3.3 core context without a window, made current at construction: by surfaceless EGL,
/// which needs no desktop, or else a hidden window. At most one at a time.
class OffScreenContext {
 public:
  /// Throws WorldError if neither is available.
  OffScreenContext();

 private:
  std::shared_ptr<void> context_;  ///< the EGL context, or the hidden window
};

}  // namespace slipstream::opengl
