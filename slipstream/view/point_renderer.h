#pragma once

#include <array>
#include <cstddef>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "slipstream/base/colour_map.h"
#include "slipstream/view/cloud_extent.h"
#include "slipstream/view/picture_texture.h"
#include "slipstream/view/point_images.h"
#include "slipstream/view/resource.h"
#include "slipstream/view/shader_program.h"

namespace slipstream::view {

/// How points are drawn in one pass.
struct PointPass {
  glm::mat4 clip{1};           ///< from the scanner's frame
  float point_size = 1;        ///< mm
  float size_depth = 1;        ///< mm; a camera's points are larger beyond it, as its pixels are
  float pixels_per_slope = 1;  ///< see pixels_per_slope()
  bool coloured = false;       ///< by depth; else grey by the value
  Range range = {};            ///< of the depth, mm, or of the value: from black to white
  bool shaded = false;         ///< where the cloud has a shading
  float floor = 1e30F;         ///< Y below which nothing is drawn, mm
  glm::vec3 veil{0};           ///< what colours are mixed with
  float strength = 1;          ///< of the colours against the veil
  int every = 1;               ///< of so many points one is drawn
};

/// A cloud in the graphics memory. Its images go there as they are: a pixel without a point is
/// skipped by the shader.
class PointRenderer {
 public:
  PointRenderer();

  /// `value`: what a grey point's brightness says, of the cloud's size.
  void upload(const PointImages& cloud, const Image<float>& value);
  /// Into the bound framebuffer, with depth test.
  void draw(const PointPass& pass) const;
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  void upload_image(std::size_t which, const Image<float>& image);
  void point_at(int every, bool shaded) const;

  opengl::ShaderProgram program_;
  opengl::Resource vertex_array_;
  std::array<opengl::Resource, 5> buffers_;  ///< x, y, z, value, shading
  opengl::PictureTexture colours_;
  std::size_t count_ = 0;
  bool organised_ = false, shaded_ = false;
};

}  // namespace slipstream::view
