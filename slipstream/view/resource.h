#pragma once

#include <utility>

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
Resource make_framebuffer();
Resource make_renderbuffer();

}  // namespace slipstream::opengl
