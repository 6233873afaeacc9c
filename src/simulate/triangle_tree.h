#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "simulate/ray_packet.h"
#include "slipstream/scene.h"

namespace slipstream {

/// A triangle of a mesh: a corner, the sides from there, and their cross product, which is zero for
/// a triangle without area.
struct TreeTriangle {
  Eigen::Vector3d corner, side_a, side_b, normal;
};

/// A box around triangles: with `count` of them from `next` on, or with two smaller boxes, the next
/// node and node `next`.
struct TreeNode {
  std::array<float, 3> low, high;
  std::int32_t next = 0;
  std::int16_t count = 0;
  std::int16_t axis = 0;  ///< along which the smaller boxes follow each other
};

/// The triangles of a mesh in a tree of boxes, for packets of rays.
class TriangleTree {
 public:
  /// Throws Error without triangles, or if one refers to a missing vertex.
  explicit TriangleTree(const Mesh& mesh);

  /// Sets `distance` and `triangle` of the rays that meet a triangle before `distance`, which may
  /// be infinite; rays of negative distance are left out.
  void find_first(const Eigen::Vector3d& origin, const LaneVectors& directions, Lanes& distance,
                  std::array<int, packet_rays>& triangle) const;

  /// Sets `distance` of the rays that meet a triangle before it to -1.
  void find_any(const Eigen::Vector3d& origin, const LaneVectors& directions,
                Lanes& distance) const;

  [[nodiscard]] const Eigen::Vector3d& normal(int triangle) const {
    return triangles_[triangle].normal;
  }

 private:
  std::vector<TreeNode> nodes_;
  std::vector<TreeTriangle> triangles_;
};

}  // namespace slipstream
