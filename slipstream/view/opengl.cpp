#include "slipstream/view/opengl.h"

#include <algorithm>
#include <string>

#include <epoxy/gl.h>
#include <fmt/format.h>
#include <glm/gtc/type_ptr.hpp>

#include "slipstream/base/error.h"

namespace slipstream::opengl {
namespace {

/// By reference: epoxy has OpenGL's functions as variables.
template <auto& generate, auto& remove>
Resource make() {
  GLuint number = 0;
  generate(1, &number);
  return {number, [](unsigned old) { remove(1, &old); }};
}

/// Of a shader or a program, by its own functions of OpenGL.
template <class Query, class Log>
void require_good(GLuint number, GLenum status, const Query& query, const Log& log,
                  const char* failure) {
  GLint good = GL_FALSE;
  query(number, status, &good);
  if (good == GL_TRUE) return;
  std::string words(2048, '\0');
  GLsizei length = 0;
  log(number, static_cast<GLsizei>(words.size()), &length, words.data());
  words.resize(static_cast<std::size_t>(std::max(length, 0)));
  throw WorldError(fmt::format("{}: {}", failure, words));
}

Resource compile(GLenum kind, const char* source) {
  Resource shader(glCreateShader(kind), [](unsigned old) { glDeleteShader(old); });
  glShaderSource(shader.number(), 1, &source, nullptr);
  glCompileShader(shader.number());
  require_good(shader.number(), GL_COMPILE_STATUS, glGetShaderiv, glGetShaderInfoLog,
               "OpenGL does not compile a shader");
  return shader;
}

}  // namespace

Resource make_buffer() {
  return make<glGenBuffers, glDeleteBuffers>();
}

Resource make_vertex_array() {
  return make<glGenVertexArrays, glDeleteVertexArrays>();
}

Resource make_texture() {
  return make<glGenTextures, glDeleteTextures>();
}

ShaderProgram::ShaderProgram(const ShaderSources& sources)
    : program_(glCreateProgram(), [](unsigned old) { glDeleteProgram(old); }) {
  const auto attach = [&](GLenum kind, const char* source) {
    if (source == nullptr) return;
    const Resource shader = compile(kind, source);
    glAttachShader(program_.number(), shader.number());
  };
  attach(GL_VERTEX_SHADER, sources.vertex);
  attach(GL_GEOMETRY_SHADER, sources.geometry);
  attach(GL_FRAGMENT_SHADER, sources.fragment);
  glLinkProgram(program_.number());
  require_good(program_.number(), GL_LINK_STATUS, glGetProgramiv, glGetProgramInfoLog,
               "OpenGL does not link the shaders");
}

void ShaderProgram::use() const {
  glUseProgram(program_.number());
}

void ShaderProgram::set(const char* name, int value) const {
  glUniform1i(location(name), value);
}

void ShaderProgram::set(const char* name, float value) const {
  glUniform1f(location(name), value);
}

void ShaderProgram::set(const char* name, const glm::vec2& value) const {
  glUniform2fv(location(name), 1, glm::value_ptr(value));
}

void ShaderProgram::set(const char* name, const glm::vec3& value) const {
  glUniform3fv(location(name), 1, glm::value_ptr(value));
}

void ShaderProgram::set(const char* name, const glm::mat4& value) const {
  glUniformMatrix4fv(location(name), 1, GL_FALSE, glm::value_ptr(value));
}

int ShaderProgram::location(const char* name) const {
  return glGetUniformLocation(program_.number(), name);
}

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

RenderTarget::RenderTarget(Size size)
    : size_(size),
      colour_(make<glGenRenderbuffers, glDeleteRenderbuffers>()),
      depth_(make<glGenRenderbuffers, glDeleteRenderbuffers>()),
      framebuffer_(make<glGenFramebuffers, glDeleteFramebuffers>()) {
  GLint longest = 0;
  glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &longest);
  if (std::max(size.width, size.height) > longest || std::min(size.width, size.height) < 1) {
    throw Error(fmt::format("a picture of {}x{} cannot be drawn; 1 to {} pixels on a side",
                            size.width, size.height, longest));
  }
  const auto allocate = [&](const Resource& buffer, GLenum format) {
    glBindRenderbuffer(GL_RENDERBUFFER, buffer.number());
    glRenderbufferStorage(GL_RENDERBUFFER, format, size.width, size.height);
  };
  allocate(colour_, GL_RGBA8);
  allocate(depth_, GL_DEPTH_COMPONENT24);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.number());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                            colour_.number());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_.number());
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw WorldError(
        fmt::format("OpenGL has no memory for a picture of {}x{}", size.width, size.height));
  }
}

void RenderTarget::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.number());
  glViewport(0, 0, size_.width, size_.height);
}

Image<Colour> read_pixels(Size size) {
  static_assert(sizeof(Colour) == 3);
  Image<Colour> upside_down(size), picture(size);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, size.width, size.height, GL_RGB, GL_UNSIGNED_BYTE, upside_down.row(0));
  for (int row = 0; row < size.height; ++row) {
    std::copy_n(upside_down.row(size.height - 1 - row), size.width, picture.row(row));
  }
  return picture;
}

}  // namespace slipstream::opengl
