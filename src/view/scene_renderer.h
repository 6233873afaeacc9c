#pragma once

#include <array>
#include <cstddef>

#include <glm/mat3x3.hpp>

#include "slipstream/viewer.h"
#include "view/edge_shading.h"
#include "view/lines.h"
#include "view/opengl.h"
#include "view/orbit_camera.h"

namespace slipstream::view {

/// A cloud to draw: borrowed images of one size. A single row is a list of points; several rows are
/// a camera's grid, whose neighbours lie on one surface.
struct PointImages {
  const Image<float>&x, &y, &z;           ///< mm, scanner's frame; NaN if invalid
  const Image<float>& intensity;          ///< grey levels of 255
  const Image<float>* shading = nullptr;  ///< brightness, 0 to 1; null: 1 everywhere
  const Image<Colour>* colour = nullptr;  ///< null: unknown
};

struct Range {
  float low = 0, high = 1;
};

/// 1st to 99th percentile of a few thousand evenly spaced finite values; [0, 1] if there are none.
Range robust_range(const Image<float>& values);

/// Position and density of a cloud, robust against a few outliers.
struct CloudExtent {
  Box box;            ///< robust_range in each direction
  Range depths;       ///< of the object, without a background far behind it
  float spacing = 1;  ///< distance between neighbouring points along the surface, mm
  float noise = 0;  ///< standard deviation of depth between neighbours, mm; 0 for a list of points
};

/// An empty cloud gives a box of one millimetre.
CloudExtent extent_of(const PointImages& cloud);

/// Y of the floor, mm: slightly under the cloud, so that it does not cut the object.
float floor_height(const CloudExtent& extent);

/// Draws the cloud with floor, reflection and axes. Its images are uploaded unchanged: the shader
/// skips invalid pixels.
class SceneRenderer {
 public:
  SceneRenderer();

  /// `modulation`: B^c of the cloud's pixels; null if unknown: the intensity is used.
  void set_cloud(const PointImages& cloud, const Image<float>* modulation, PointColour colour);
  /// Directions of the axes that are drawn, in the scanner's frame, as columns.
  void set_axes(const glm::mat3& directions) { directions_ = directions; }
  /// Extent that places the floor, the axes and the depth colours.
  void set_extent(const CloudExtent& extent) { extent_ = extent; }
  [[nodiscard]] const CloudExtent& extent() const { return extent_; }
  /// Range of the depth colours, mm: slightly more than the extent's, so that its ends differ.
  /// Points beyond have the colours of its ends.
  [[nodiscard]] Range depths() const;

  /// Whether points show depth: if requested, or if nothing else is known, as for a plain mesh.
  [[nodiscard]] bool shows_depths(PointColour chosen) const {
    return chosen == PointColour::depth || (values_.high <= 0 && !in_colour_);
  }

  /// Clears the bound framebuffer and draws into a pane of it. `ambient`: ambient light contained
  /// in the cloud's intensities. `pixel_ratio`: line width factor on a HiDPI screen.
  void draw(const ViewSettings& settings, double ambient, const Pane& pane,
            float pixel_ratio = 1) const;

 private:
  void draw_view(const ViewSettings& settings, double ambient, const Pane& pane,
                 float pixel_ratio) const;
  void draw_points(const ViewSettings& settings, double ambient, Size picture, bool mirrored) const;

  opengl::ShaderProgram program_;
  opengl::Resource vertex_array_;
  std::array<opengl::Resource, 5> buffers_;  ///< x, y, z, value, shading
  opengl::PictureTexture colours_;
  std::size_t count_ = 0;
  bool organised_ = false, shaded_ = false;
  bool in_colour_ = false;  ///< its values are colours
  LineRenderer lines_;
  EdgeShading edges_;
  CloudExtent extent_;
  glm::mat3 directions_{1};
  Range values_;  ///< shown by grey points
};

}  // namespace slipstream::view
