#pragma once

#include <vector>

#include "slipstream/cloud/cloud.h"

namespace slipstream {

/// Unit surface normals of an organised cloud, towards the camera; NaN where a point or too many of
/// its neighbours are missing.
struct Normals {
  Image<float> x, y, z;
};

/// From the differences to the four neighbours in the picture, without those across an edge:
/// farther in depth than eight times the distance between pixels there.
Normals surface_normals(const Cloud& cloud);

/// Their mean over 5x5 pixels, of unit length, so that noise shows less; NaN where the pixel itself
/// has no point.
Normals smoothed_normals(const Cloud& cloud);

/// How bright each point of an organised cloud looks under a light over the viewer's left shoulder:
/// 0.3 where turned away, 1 where facing it, in between where the slope is not known. From
/// smoothed_normals: the form shows, not the noise of depth.
Image<float> shading(const Cloud& cloud);

/// A cloud's points joined by triangles, in the camera's frame, with the camera's picture on it.
struct Surface {
  std::vector<Eigen::Vector3f> vertices{};  ///< mm; each the corner of a triangle
  std::vector<float> intensity{};           ///< of each vertex, as the cloud's
  /// Where each vertex lies in the picture: right and down from its upper left corner, 0 to 1.
  std::vector<Eigen::Vector2f> texture{};
  /// By the indices of their corners, counter-clockwise as the camera sees them.
  std::vector<std::array<std::uint32_t, 3>> triangles{};
  Image<std::uint8_t> picture{};
};

/// Joins neighbouring pixels' points in blocks of two by two: two triangles, divided along the
/// smaller step in depth, or one where a point is missing. Depths of a triangle's corners differ by
/// at most `largest_step` times the distance between their rays.
Surface surface_of(const Cloud& cloud, double largest_step = 8);

}  // namespace slipstream
