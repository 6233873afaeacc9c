#pragma once

#include <array>
#include <cstddef>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "slipstream/base/colour.h"
#include "slipstream/base/image.h"
#include "slipstream/view/opengl.h"
#include "slipstream/view/orbit_camera.h"

namespace slipstream::view {

/// A cloud as it is drawn: images of one size, which are not copied. One of a single row is a list
/// of points; of more, a camera's picture, whose neighbours lie on one surface.
struct PointImages {
  const Image<float>& x;  ///< mm, scanner's frame; a pixel without a point is NaN, as y and z
  const Image<float>& y;
  const Image<float>& z;
  const Image<float>& intensity;          ///< grey levels of an 8-bit camera
  const Image<float>* shading = nullptr;  ///< how bright, 0 to 1; null: all as bright
};

/// From a low to a high value.
struct Range {
  float low = 0;
  float high = 1;
};

/// From the 1st to the 99th percentile of the finite values, of some thousands of them evenly
/// spread; [0, 1] where none is finite.
Range robust_range(const Image<float>& values);

/// Where a cloud is and how dense, so that a few outliers do not matter.
struct CloudExtent {
  Box box;            ///< robust_range in each direction
  float spacing = 1;  ///< mm from a point to the next at the middle depth, the median
};

/// Of an empty cloud: the box of a millimetre.
CloudExtent extent_of(const PointImages& cloud);

/// Y of the floor, mm: a little under the cloud, so that it does not cut what stands on it.
float floor_height(const CloudExtent& extent);

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
