#pragma once

#include <memory>

#include "slipstream/base/colour.h"
#include "slipstream/base/image.h"
#include "slipstream/base/size.h"
#include "slipstream/view/resource.h"

namespace slipstream::opengl {

/// An OpenGL 3.3 core context without a window, current from its making on: of EGL without any
/// surface, which needs no desktop, else of a hidden window. One at a time.
class OffScreenContext {
 public:
  /// Throws WorldError where neither is to be had.
  OffScreenContext();
  OffScreenContext(const OffScreenContext&) = delete;
  OffScreenContext& operator=(const OffScreenContext&) = delete;
  ~OffScreenContext();

 private:
  class Egl;
  class HiddenWindow;
  std::unique_ptr<Egl> egl_;
  std::unique_ptr<HiddenWindow> hidden_window_;
};

/// A picture that is drawn into: colour and depth.
class RenderTarget {
 public:
  /// Throws Error for a size out of range, WorldError where the driver has none of that size.
  explicit RenderTarget(Size size);

  /// What is drawn from here on goes into it, to all of it.
  void bind() const;
  [[nodiscard]] Size size() const { return size_; }

 private:
  Size size_;
  Resource colour_, depth_, framebuffer_;
};

/// What was drawn into the framebuffer that is bound, its first row at the top.
Image<Colour> read_pixels(Size size);

}  // namespace slipstream::opengl
