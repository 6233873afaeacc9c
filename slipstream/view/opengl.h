#pragma once

#include <utility>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "slipstream/base/colour.h"
#include "slipstream/base/image.h"
#include "slipstream/base/size.h"

// What OpenGL keeps of a drawing, for the context that is current when it is made.
namespace slipstream::opengl {

/// The number by which OpenGL knows a buffer, texture or the like; it is deleted with its holder,
/// which must not outlive the context it was made in.
class Resource {
 public:
  using Delete = void (*)(unsigned number);

  Resource() = default;
  Resource(unsigned number, Delete remove) : number_(number), remove_(remove) {}
  Resource(Resource&& other) noexcept
      : number_(std::exchange(other.number_, 0)), remove_(other.remove_) {}
  Resource& operator=(Resource other) noexcept {
    std::swap(number_, other.number_);
    std::swap(remove_, other.remove_);
    return *this;
  }
  ~Resource() {
    if (number_ != 0) remove_(number_);
  }

  [[nodiscard]] unsigned number() const { return number_; }

 private:
  unsigned number_ = 0;
  Delete remove_ = nullptr;
};

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
  /// Of the program in use; ignores a name that the shaders do not have.
  void set(const char* name, int value) const;
  void set(const char* name, float value) const;
  void set(const char* name, const glm::vec2& value) const;
  void set(const char* name, const glm::vec3& value) const;
  void set(const char* name, const glm::mat4& value) const;

 private:
  [[nodiscard]] int location(const char* name) const;

  Resource program_;
};

/// A picture in the graphics memory.
class PictureTexture {
 public:
  /// The picture that it is from here on.
  void upload(const Image<Colour>& picture);
  [[nodiscard]] unsigned number() const { return texture_.number(); }
  [[nodiscard]] Size size() const { return size_; }

 private:
  Resource texture_ = make_texture();
  Size size_;
};

/// A picture that is drawn into: colour and depth.
class RenderTarget {
 public:
  /// Throws Error for a size out of range, WorldError where the driver has none of that size.
  explicit RenderTarget(Size size);

  /// What is drawn from here on goes into it, to all of it.
  void bind() const;

 private:
  Size size_;
  Resource colour_, depth_, framebuffer_;
};

/// What was drawn into the framebuffer that is bound, its first row at the top.
Image<Colour> read_pixels(Size size);

}  // namespace slipstream::opengl
