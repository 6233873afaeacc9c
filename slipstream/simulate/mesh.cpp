#include "slipstream/simulate/mesh.h"

#include <limits>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <unsupported/Eigen/BVH>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

using Bounds = Eigen::AlignedBox3d;
using BoxTree = Eigen::KdBVH<double, 3, int>;

Bounds box_around(const Mesh& mesh, const std::array<int, 3>& triangle) {
  Bounds box;
  for (const int corner : triangle) box.extend(mesh.vertices[static_cast<std::size_t>(corner)]);
  return box;
}

/// What Eigen's tree search asks: may this box hold a nearer hit, and does this triangle?
class NearestHit {
 public:
  NearestHit(const Mesh& mesh, const Ray& ray)
      : mesh_(mesh), ray_(ray), inverse_(ray.direction.cwiseInverse()) {}

  bool intersectVolume(const Bounds& box) const {
    const Eigen::Array3d a = (box.min() - ray_.origin).array() * inverse_.array();
    const Eigen::Array3d b = (box.max() - ray_.origin).array() * inverse_.array();
    const double enter = a.min(b).maxCoeff();
    const double leave = a.max(b).minCoeff();
    return enter <= leave && leave > 0 && enter < nearest_;
  }

  bool intersectObject(int index) {
    const auto& [i, j, k] = mesh_.triangles[static_cast<std::size_t>(index)];
    const Eigen::Vector3d& corner = mesh_.vertices[static_cast<std::size_t>(i)];
    const Eigen::Vector3d side_a = mesh_.vertices[static_cast<std::size_t>(j)] - corner;
    const Eigen::Vector3d side_b = mesh_.vertices[static_cast<std::size_t>(k)] - corner;
    const Eigen::Vector3d normal = side_a.cross(side_b);
    const double facing = ray_.direction.dot(normal);
    if (facing == 0) return false;
    const Eigen::Vector3d to_corner = corner - ray_.origin;
    const double distance = to_corner.dot(normal) / facing;
    if (distance <= 0 || distance >= nearest_) return false;
    const Eigen::Vector3d moment = ray_.direction.cross(to_corner);
    const double a = -side_b.dot(moment) / facing;
    const double b = side_a.dot(moment) / facing;
    if (a < 0 || b < 0 || a + b > 1) return false;
    nearest_ = distance;
    normal_ = normal;
    return false;
  }

  [[nodiscard]] std::optional<Hit> hit() const {
    if (nearest_ == std::numeric_limits<double>::infinity()) return std::nullopt;
    return Hit{nearest_, normal_};
  }

 private:
  const Mesh& mesh_;
  const Ray& ray_;
  Eigen::Vector3d inverse_;
  double nearest_ = std::numeric_limits<double>::infinity();
  Eigen::Vector3d normal_ = Eigen::Vector3d::Zero();
};

}  // namespace

struct MeshTree::Tree {
  BoxTree boxes;
};

void append_surface(Mesh& mesh, int rows, int columns,
                    const std::function<Eigen::Vector3d(double u, double v)>& point) {
  const int first = static_cast<int>(mesh.vertices.size());
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column <= columns; ++column) {
      mesh.vertices.push_back(
          point(static_cast<double>(column) / columns, static_cast<double>(row) / rows));
    }
  }
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int corner = first + row * (columns + 1) + column;
      const int below = corner + columns + 1;
      mesh.triangles.push_back({corner, below, corner + 1});
      mesh.triangles.push_back({corner + 1, below, below + 1});
    }
  }
}

MeshTree::MeshTree(Mesh mesh) : mesh_(std::move(mesh)) {
  if (mesh_.triangles.empty()) throw Error("the mesh has no triangle");
  std::vector<int> indices;
  std::vector<Bounds> boxes;
  for (const std::array<int, 3>& triangle : mesh_.triangles) {
    for (const int corner : triangle) {
      if (corner < 0 || static_cast<std::size_t>(corner) >= mesh_.vertices.size()) {
        throw Error(fmt::format("a triangle of the mesh names vertex {} of {}", corner,
                                mesh_.vertices.size()));
      }
    }
    indices.push_back(static_cast<int>(indices.size()));
    boxes.push_back(box_around(mesh_, triangle));
  }
  tree_ = std::make_shared<const Tree>(
      Tree{BoxTree(indices.begin(), indices.end(), boxes.begin(), boxes.end())});
}

std::optional<Hit> MeshTree::first_hit(const Ray& ray) const {
  NearestHit nearest(mesh_, ray);
  Eigen::BVIntersect(tree_->boxes, nearest);
  return nearest.hit();
}

}  // namespace slipstream
