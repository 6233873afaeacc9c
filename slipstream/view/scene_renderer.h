#pragma once

#include <string_view>
#include <vector>

#include "slipstream/view/lines.h"
#include "slipstream/view/orbit_camera.h"
#include "slipstream/view/points.h"

namespace slipstream::view {

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
  int left = 0;
  int bottom = 0;
  Size size;
};

/// The cloud with its floor, its reflection in it and the axes.
class SceneRenderer {
 public:
  /// The cloud that is drawn from here on. `modulation`: B^c of its pixels; null where not known,
  /// and then its intensity stands in.
  void set_cloud(const PointImages& cloud, const Image<float>* modulation, PointColour colour);
  /// The floor, the axes and the colours of depth are placed by this extent.
  void set_extent(const CloudExtent& extent) { extent_ = extent; }
  [[nodiscard]] const CloudExtent& extent() const { return extent_; }
  /// What the colours of depth span, mm: a little more than the extent, so that its ends have
  /// colours apart.
  [[nodiscard]] Range depths() const;

  /// Whether points have the colours of their depth: asked for, or nothing else is known of them,
  /// as of a mesh without a picture.
  [[nodiscard]] bool shows_depths(PointColour asked) const {
    return asked == PointColour::depth || values_.high <= 0;
  }

  /// Into a pane of the bound framebuffer, which is cleared. `ambient`: the light in the cloud's
  /// intensities that is not the projector's. `pixel_ratio`: by how much lines are
  /// wider than a pixel, on a HiDPI screen.
  void draw(const ViewSettings& settings, double ambient, const Pane& pane,
            float pixel_ratio = 1) const;

 private:
  PointRenderer points_;
  LineRenderer lines_;
  CloudExtent extent_;
  Range values_;
};

}  // namespace slipstream::view
