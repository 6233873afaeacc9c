#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slipstream/base/colour.h"
#include "slipstream/base/image.h"

struct GLFWwindow;

namespace slipstream::opengl {

/// OpenGL's number of a buffer, texture or the like in the context that is current when it is made;
/// deleted with its last holder, which must not outlive that context.
using Resource = std::shared_ptr<const unsigned>;

Resource make_buffer();
Resource make_vertex_array();
Resource make_texture();

/// Sources in GLSL 3.30; a geometry shader only where there is one.
struct ShaderSources {
  const char* vertex = nullptr;
  const char* geometry = nullptr;
  const char* fragment = nullptr;
};

/// Shaders, compiled and linked.
class ShaderProgram {
 public:
  /// Throws WorldError with the driver's words where it does not take them.
  explicit ShaderProgram(const ShaderSources& sources);

  void use() const;
  /// Location for glUniform...; OpenGL ignores that of a name that the shaders do not have.
  [[nodiscard]] int uniform(const char* name) const;

 private:
  Resource program_;
};

/// A picture in the graphics memory.
class PictureTexture {
 public:
  void upload(const Image<Colour>& picture);
  [[nodiscard]] unsigned number() const { return *texture_; }
  [[nodiscard]] Size size() const { return size_; }

 private:
  Resource texture_ = make_texture();
  Size size_;
};

/// A picture that is drawn into, with depth.
class RenderTarget {
 public:
  /// Throws Error for a size out of range, WorldError where the driver has none of that size.
  explicit RenderTarget(Size size);

  /// Draws into all of it from here on.
  void bind() const;

 private:
  Size size_;
  Resource colour_, depth_, framebuffer_;
};

/// The bound framebuffer's picture, its first row at the top.
Image<Colour> read_pixels(Size size);

/// The connection to the desktop; one at a time, in the main thread, and outliving every Window.
class WindowSystem {
 public:
  /// Throws WorldError where there is no desktop to connect to.
  WindowSystem();
  WindowSystem(const WindowSystem&) = delete;
  WindowSystem& operator=(const WindowSystem&) = delete;
  ~WindowSystem();

  /// A screen, or a projector that is one.
  struct Monitor {
    std::string name;
    Size size;  ///< pixels
    int left = 0, top = 0;
    int refresh_hz = 0;
  };
  /// The first is the desktop's main one.
  [[nodiscard]] std::vector<Monitor> monitors() const;
};

/// How a window opens.
struct WindowSettings {
  std::string title = "slipstream";
  Size size{1280, 800};    ///< of its inside; the monitor's where it fills one
  bool visible = true;     ///< one that is not serves to draw off-screen
  int fills_monitor = -1;  ///< number of the monitor that it fills without a frame; none below 0
};

/// A window with an OpenGL 3.3 core context, which is current from its making on.
class Window {
 public:
  /// Throws Error for a monitor that is not there, WorldError where the desktop or its OpenGL does
  /// not give a window.
  Window(const WindowSystem& system, const WindowSettings& settings);

  [[nodiscard]] GLFWwindow* get() const { return window_.get(); }
  [[nodiscard]] Size framebuffer_size() const;  ///< in pixels

 private:
  struct Close {
    void operator()(GLFWwindow* window) const;
  };
  std::unique_ptr<GLFWwindow, Close> window_;
};

/// An OpenGL 3.3 core context without a window, current from its making on: of EGL without any
/// surface, which needs no desktop, else of a hidden window. One at a time.
class OffScreenContext {
 public:
  /// Throws WorldError where neither is to be had.
  OffScreenContext();

 private:
  std::shared_ptr<void> context_;  ///< of EGL, or the hidden window
};

}  // namespace slipstream::opengl
