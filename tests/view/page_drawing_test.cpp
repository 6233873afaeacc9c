// The shaders of the web page: the driver compiles them as OpenGL ES, here as their OpenGL.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>

#include <gtest/gtest.h>

#include "view/opengl.h"

namespace slipstream::view {
namespace {

TEST(PageDrawing, HasShadersThatCompile) {
  const opengl::OffScreenContext context;
  const std::string path = SLIPSTREAM_SOURCE_FOLDER "/src/publish/page_drawing.js";
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::string version = "#version 330 core\nprecision highp float;\n";
  const std::regex pair(R"(program\(`([^`]*)`,\s*[`']([^`']*)[`']\))");

  int count = 0;
  for (std::sregex_iterator at(text.begin(), text.end(), pair), end; at != end; ++at, ++count) {
    const std::string vertex = version + (*at)[1].str(), fragment = version + (*at)[2].str();
    opengl::ShaderProgram({vertex.c_str(), nullptr, fragment.c_str()}, path.c_str());
  }
  EXPECT_GE(count, 2);
}

}  // namespace
}  // namespace slipstream::view
