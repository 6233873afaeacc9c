#pragma once

#include <string_view>
#include <vector>

#include "slipstream/view/orbit_camera.h"

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

}  // namespace slipstream::view
