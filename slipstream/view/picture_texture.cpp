#include "slipstream/view/picture_texture.h"

#include <epoxy/gl.h>

namespace slipstream::opengl {

PictureTexture::PictureTexture() : texture_(make_texture()) {}

void PictureTexture::upload(const Image<Colour>& picture) {
  glBindTexture(GL_TEXTURE_2D, texture_.number());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
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

}  // namespace slipstream::opengl
