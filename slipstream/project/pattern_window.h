#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slipstream/image/image.h"
#include "slipstream/opengl/resource.h"
#include "slipstream/opengl/shader_program.h"
#include "slipstream/opengl/window.h"

namespace slipstream::project {

/// Patterns on a projector that is a monitor: it is filled pixel for pixel, without frame or
/// cursor.
class PatternWindow {
 public:
  /// `patterns` are of the monitor's size, 8 bits. Throws Error where they are not, or for a
  /// monitor that is not there; WorldError where there is no OpenGL.
  PatternWindow(const opengl::WindowSystem& system, int monitor,
                const std::vector<Image<std::uint8_t>>& patterns);

  /// Draws pattern n, not yet to be seen.
  void draw(std::size_t n) const;
  /// Shows what was drawn from the monitor's next refresh on, and returns once it has begun, where
  /// the driver waits for it.
  void show() const;
  /// Whether Esc was pressed or the window closed. Answers the desktop meanwhile.
  [[nodiscard]] bool closed() const;
  [[nodiscard]] const opengl::Window& window() const { return window_; }

 private:
  opengl::Window window_;
  opengl::ShaderProgram program_;
  opengl::Resource vertex_array_;
  std::vector<opengl::Resource> textures_;
  Size size_;
};

}  // namespace slipstream::project
