#pragma once

#include <array>

#include "slipstream/view/resource.h"

namespace slipstream::opengl {

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
  /// Of the program in use; a name that the shaders do not have is passed over. Matrices by
  /// columns.
  void set(const char* name, int value) const;
  void set(const char* name, float value) const;
  void set(const char* name, const std::array<float, 2>& value) const;
  void set(const char* name, const std::array<float, 3>& value) const;
  void set_matrix(const char* name, const float* columns) const;

 private:
  [[nodiscard]] int location(const char* name) const;

  Resource program_;
};

}  // namespace slipstream::opengl
