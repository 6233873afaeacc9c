#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "slipstream/view/opengl.h"
#include "slipstream/view/orbit_camera.h"

namespace slipstream::view {

/// A cloud as it is drawn: images of one size, not copied. A single row is a list of points; more
/// are a camera's picture, whose neighbours lie on one surface.
struct PointImages {
  const Image<float>&x, &y, &z;           ///< mm, scanner's frame; NaN without a point
  const Image<float>& intensity;          ///< grey levels of an 8-bit camera
  const Image<float>* shading = nullptr;  ///< how bright, 0 to 1; null: all as bright
};

/// From a low to a high value.
struct Range {
  float low = 0, high = 1;
};

/// From the 1st to the 99th percentile of some thousands of the finite values, evenly spread; [0,
/// 1] where none is finite.
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

struct Line {
  glm::vec3 from{0}, to{0};
  glm::vec3 colour{1};  ///< red, green, blue, 0 to 1
  float opacity = 1;
};

/// Straight lines of any width with smooth edges.
class LineRenderer {
 public:
  LineRenderer();

  /// Into the bound framebuffer of that size, behind what is nearer. `width`: pixels.
  void draw(const std::vector<Line>& lines, const glm::mat4& clip, Size picture, float width) const;

 private:
  opengl::ShaderProgram program_;
  opengl::Resource vertex_array_, buffer_;
};

/// The scanner's axes from the box's lower left front corner, X blue, Y green and Z red as in Liu
/// 2010, Fig. 2.3, with letters that face the eye.
std::vector<Line> axes(const Box& box, const OrbitCamera& camera);

/// Distance between the lines of the floor's grid: a round number of millimetres.
float grid_step(const Box& box);

/// The floor: lines along X and Z in the plane Y = `height`, under and round the box.
std::vector<Line> floor_grid(const Box& box, float height);

/// What a point's colour says.
enum class PointColour {
  reflectivity,  ///< alpha, from the mean freed of ambient light, Liu 2010, Eq. (3.3)
  modulation,    ///< B^c
  depth,         ///< Z
};

/// "reflectivity", "modulation", "depth"; throws Error for any other name.
PointColour point_colour_named(std::string_view name);
std::vector<std::string_view> point_colour_names();

/// How a cloud is drawn.
struct ViewSettings {
  PointColour colour = PointColour::reflectivity;
  float point_size = 1.5F;  ///< in distances from a point to its neighbour: from 1 on no gaps
  float brightness = 1;     ///< of the grey levels; 1: the brightest hundredth is white
  bool shaded = true;       ///< by the surface's slope, where the cloud is a camera's picture
  bool reflection = true;   ///< in the floor, which is parallel to the XZ plane
  bool axes = true;
  bool grid = true;  ///< of the floor
  OrbitCamera camera{.azimuth = 0.33F, .elevation = 0.22F};
};

/// A part of the framebuffer, in pixels from its lower left corner.
struct Pane {
  int left = 0, bottom = 0;
  Size size;
};

/// The cloud with its floor, its reflection in it and the axes. Its images go to the graphics
/// memory as they are: the shader skips pixels without a point.
class SceneRenderer {
 public:
  SceneRenderer();

  /// `modulation`: B^c of the cloud's pixels; null if not known: its intensity stands in.
  void set_cloud(const PointImages& cloud, const Image<float>* modulation, PointColour colour);
  /// The floor, the axes and the colours of depth are placed by this extent.
  void set_extent(const CloudExtent& extent) { extent_ = extent; }
  [[nodiscard]] const CloudExtent& extent() const { return extent_; }
  /// Span of the colours of depth, mm: a little more than the extent, so that its ends differ.
  [[nodiscard]] Range depths() const;

  /// Whether points show their depth: if asked for, or nothing else is known, as of a plain mesh.
  [[nodiscard]] bool shows_depths(PointColour asked) const {
    return asked == PointColour::depth || values_.high <= 0;
  }

  /// Clears the bound framebuffer and draws into a pane of it. `ambient`: the light in the cloud's
  /// intensities that is not the projector's. `pixel_ratio`: width of lines on a HiDPI screen.
  void draw(const ViewSettings& settings, double ambient, const Pane& pane,
            float pixel_ratio = 1) const;

 private:
  void draw_points(const ViewSettings& settings, double ambient, Size picture, bool mirrored) const;

  opengl::ShaderProgram program_;
  opengl::Resource vertex_array_;
  std::array<opengl::Resource, 5> buffers_;  ///< x, y, z, value, shading
  opengl::PictureTexture colours_;
  std::size_t count_ = 0;
  bool organised_ = false, shaded_ = false;
  LineRenderer lines_;
  CloudExtent extent_;
  Range values_;  ///< that grey points show
};

}  // namespace slipstream::view
