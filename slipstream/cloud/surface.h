#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "slipstream/cloud/cloud.h"

namespace slipstream {

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

/// Joins the points of neighbouring pixels, in blocks of two by two: two triangles, divided where
/// the step in depth is smaller, or one where a point is missing. No triangle has two corners whose
/// depths differ by more than `largest_step` times the distance between their rays.
Surface surface_of(const Cloud& cloud, double largest_step = 8);

}  // namespace slipstream
