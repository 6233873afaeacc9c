#pragma once

#include "slipstream/base/colour.h"
#include "slipstream/base/image.h"
#include "slipstream/view/resource.h"

namespace slipstream::opengl {

/// A picture in the graphics memory.
class PictureTexture {
 public:
  PictureTexture();

  /// The picture that it is from here on.
  void upload(const Image<Colour>& picture);
  [[nodiscard]] unsigned number() const { return texture_.number(); }
  [[nodiscard]] Size size() const { return size_; }

 private:
  Resource texture_;
  Size size_;
};

}  // namespace slipstream::opengl
