#include "slipstream/view/shader_program.h"

#include <algorithm>
#include <string>

#include <epoxy/gl.h>
#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream::opengl {
namespace {

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

void ShaderProgram::set(const char* name, const std::array<float, 2>& value) const {
  glUniform2f(location(name), value[0], value[1]);
}

void ShaderProgram::set(const char* name, const std::array<float, 3>& value) const {
  glUniform3f(location(name), value[0], value[1], value[2]);
}

void ShaderProgram::set_matrix(const char* name, const float* columns) const {
  glUniformMatrix4fv(location(name), 1, GL_FALSE, columns);
}

int ShaderProgram::location(const char* name) const {
  return glGetUniformLocation(program_.number(), name);
}

}  // namespace slipstream::opengl
