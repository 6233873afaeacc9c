#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace slipstream {

/// The points origin + distance direction, distance > 0. The direction has any length; distances
/// are in units of it, so that along a camera ray (u, v, 1) they are depths.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

/// Where a ray meets a surface.
struct Hit {
  double distance = 0;
  Eigen::Vector3d normal;  ///< of any length and sign
};

/// Triangles by the indices of their corners. Units and axes are its maker's.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
};

/// Adds the surface point(u, v), u and v in [0, 1], as a grid of `rows` x `columns` cells of two
/// triangles.
void append_surface(Mesh& mesh, int rows, int columns,
                    const std::function<Eigen::Vector3d(double u, double v)>& point);

/// A mesh that answers rays: its triangles in a tree of boxes.
class MeshTree {
 public:
  /// Throws Error when there is no triangle or one names a vertex that is not there.
  explicit MeshTree(Mesh mesh);

  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  /// The first triangle that the ray meets, from either side; the normal is the triangle's.
  [[nodiscard]] std::optional<Hit> first_hit(const Ray& ray) const;

 private:
  struct Tree;

  Mesh mesh_;
  std::shared_ptr<const Tree> tree_;
};

}  // namespace slipstream
