#include "slipstream/view/resource.h"

#include <epoxy/gl.h>

namespace slipstream::opengl {

Resource make_buffer() {
  GLuint number = 0;
  glGenBuffers(1, &number);
  return {number, [](unsigned old) { glDeleteBuffers(1, &old); }};
}

Resource make_vertex_array() {
  GLuint number = 0;
  glGenVertexArrays(1, &number);
  return {number, [](unsigned old) { glDeleteVertexArrays(1, &old); }};
}

Resource make_texture() {
  GLuint number = 0;
  glGenTextures(1, &number);
  return {number, [](unsigned old) { glDeleteTextures(1, &old); }};
}

Resource make_framebuffer() {
  GLuint number = 0;
  glGenFramebuffers(1, &number);
  return {number, [](unsigned old) { glDeleteFramebuffers(1, &old); }};
}

Resource make_renderbuffer() {
  GLuint number = 0;
  glGenRenderbuffers(1, &number);
  return {number, [](unsigned old) { glDeleteRenderbuffers(1, &old); }};
}

}  // namespace slipstream::opengl
