#include "merge/hole_filling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "merge/groups.h"

namespace slipstream {
namespace {

/// Indices of vertices, in the order in which triangles of the hole run through them.
using Rim = std::vector<std::uint32_t>;
using Triangle = std::array<std::uint32_t, 3>;

/// The directed edges of a mesh: each triangle has three.
class Edges {
 public:
  void add(const Triangle& corners) {
    for (std::size_t k = 0; k < 3; ++k) edges_.insert(key(corners[k], corners[(k + 1) % 3]));
  }
  [[nodiscard]] bool has(std::uint32_t from, std::uint32_t to) const {
    return edges_.contains(key(from, to));
  }

 private:
  static std::uint64_t key(std::uint32_t from, std::uint32_t to) {
    return std::uint64_t{from} << 32 | to;
  }

  std::unordered_set<std::uint64_t> edges_{};
};

/// A corner of the rim, between the one before it and the one after it.
Triangle corners_at(const Rim& rim, std::size_t i) {
  const std::size_t count = rim.size();
  return {rim[(i + count - 1) % count], rim[i], rim[(i + 1) % count]};
}

/// Mean direction of the vertices' normals, outwards.
Eigen::Vector3f normal_of(const std::vector<ModelPoint>& vertices, const Triangle& corners) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const std::uint32_t corner : corners) sum += vertices[corner].normal;
  return sum.normalized();
}

/// Angle of the hole at the second corner, 0 to 2 pi, seen against a direction outwards.
float angle_at(const std::vector<ModelPoint>& vertices, const Triangle& corners,
               const Eigen::Vector3f& outwards) {
  const Eigen::Vector3f& here = vertices[corners[1]].position;
  const Eigen::Vector3f in = vertices[corners[0]].position - here;
  const Eigen::Vector3f out = vertices[corners[2]].position - here;

  const float angle = std::atan2(out.cross(in).dot(outwards), out.dot(in));
  return angle < 0 ? angle + 2 * std::numbers::pi_v<float> : angle;
}

/// The closed ways along edges that have a triangle on one side only. A way may meet a vertex
/// twice, where parts of the mesh touch at a point.
std::vector<Rim> rims_of(const ModelMesh& mesh, const Edges& edges) {
  // 1. Where these edges lead. A hole's triangles run against those beside it.
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> next;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> starts;
  for (const Triangle& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t to = triangle[k], from = triangle[(k + 1) % 3];
      if (edges.has(from, to)) continue;
      next[from].push_back(to);
      starts.emplace_back(from, to);
    }
  }

  // 2. From each edge go on along open edges until back at the first. If several edges begin at a
  // vertex, the one at the smallest angle is of the same hole. An edge with more than two triangles
  // may end the way before: then these edges are not a rim.
  std::vector<Rim> rims;
  for (const auto& [first, second] : starts) {
    const bool is_known = std::ranges::count(next[first], second) == 0;
    if (is_known) continue;

    Rim rim{first, second};
    bool is_closed = false;
    while (!is_closed && !next[rim.back()].empty()) {
      std::vector<std::uint32_t>& ways = next[rim.back()];
      const auto way = std::ranges::min_element(ways, {}, [&](std::uint32_t to) {
        const Triangle corners{rim[rim.size() - 2], rim.back(), to};
        return angle_at(mesh.vertices, corners, normal_of(mesh.vertices, corners));
      });
      is_closed = rim.back() == first && *way == second;
      if (!is_closed) rim.push_back(*way);
      ways.erase(way);
    }
    rim.pop_back();
    if (is_closed) rims.push_back(std::move(rim));
  }
  return rims;
}

/// Unit normal of the plane that a rim runs round counter-clockwise (Newell).
Eigen::Vector3f normal_of(const std::vector<ModelPoint>& vertices, const Rim& rim) {
  const Eigen::Vector3f& origin = vertices[rim.front()].position;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const auto [before, here, after] = corners_at(rim, i);
    sum += (vertices[here].position - origin).cross(vertices[after].position - origin);
  }
  return sum.normalized();
}

/// Fills one rim from its sharpest corners inwards.
class RimFilling {
 public:
  RimFilling(const ModelMesh& mesh, const Edges& edges, Rim rim)
      : vertices_(mesh.vertices),
        edges_(edges),
        rim_(std::move(rim)),
        outwards_(normal_of(vertices_, rim_)) {}

  /// The triangles; nullopt if the rim cannot be filled.
  [[nodiscard]] std::optional<std::vector<Triangle>> triangles() {
    std::vector<Triangle> filled;
    while (rim_.size() > 3) {
      const auto sharpest = sharpest_corner();
      if (!sharpest) return std::nullopt;

      filled.push_back(corners_at(rim_, *sharpest));
      own_edges_.add(filled.back());
      rim_.erase(rim_.begin() + static_cast<std::ptrdiff_t>(*sharpest));
    }

    if (rim_.size() < 3) return std::nullopt;
    filled.push_back(corners_at(rim_, 1));
    return filled;
  }

 private:
  /// The corner with the smallest angle among those over whose triangle lies no other corner of the
  /// rim; in a rim so crooked that there is none, among all. nullopt if no third edge is free.
  [[nodiscard]] std::optional<std::size_t> sharpest_corner() const {
    std::optional<std::size_t> sharpest;
    float least = 0;
    bool is_clear = false;
    for (std::size_t i = 0; i < rim_.size(); ++i) {
      const Triangle corners = corners_at(rim_, i);
      const float angle = angle_at(vertices_, corners, outwards_);
      if (sharpest && is_clear && angle >= least) continue;
      if (!has_free_edge(corners)) continue;

      const bool clear = angle < std::numbers::pi_v<float> && !lies_under_another(corners);
      const bool is_better = !sharpest || (clear != is_clear ? clear : angle < least);
      if (!is_better) continue;

      sharpest = i;
      least = angle;
      is_clear = clear;
    }
    return sharpest;
  }

  /// Whether the edge between the first and the last corner is in no triangle.
  [[nodiscard]] bool has_free_edge(const Triangle& corners) const {
    const auto [before, here, after] = corners;
    if (before == after) return false;
    for (const Edges* edges : {&edges_, &own_edges_}) {
      if (edges->has(before, after) || edges->has(after, before)) return false;
    }
    return true;
  }

  /// Whether another corner of the rim is over the triangle, seen along the rim's normal.
  [[nodiscard]] bool lies_under_another(const Triangle& corners) const {
    return std::ranges::any_of(rim_, [&](std::uint32_t other) {
      if (std::ranges::count(corners, other) != 0) return false;
      for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3f& from = vertices_[corners[k]].position;
        const Eigen::Vector3f& to = vertices_[corners[(k + 1) % 3]].position;
        const Eigen::Vector3f beyond = vertices_[other].position - from;
        if ((to - from).cross(beyond).dot(outwards_) <= 0) return false;
      }
      return true;
    });
  }

  const std::vector<ModelPoint>& vertices_;
  const Edges& edges_;
  Edges own_edges_{};
  Rim rim_;
  const Eigen::Vector3f outwards_;
};

float width_of(const ModelMesh& mesh, const Rim& rim) {
  Eigen::AlignedBox3f box;
  for (const std::uint32_t corner : rim) box.extend(mesh.vertices[corner].position);
  return box.diagonal().norm();
}

/// Of each vertex, whether it is in a piece that floats: one of far fewer triangles than the
/// largest.
std::vector<bool> floating_vertices(const ModelMesh& mesh) {
  constexpr std::size_t far_fewer = 100;  // times

  // 1. The pieces.
  Groups pieces(mesh.vertices.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    pieces.connect(a, b);
    pieces.connect(a, c);
  }

  // 2. Their sizes.
  std::vector<std::size_t> triangles(mesh.vertices.size());
  std::size_t most = 0;
  for (const Triangle& triangle : mesh.triangles) {
    most = std::max(most, ++triangles[pieces.root(triangle[0])]);
  }

  std::vector<bool> floats(mesh.vertices.size());
  for (std::size_t vertex = 0; vertex < floats.size(); ++vertex) {
    floats[vertex] = far_fewer * triangles[pieces.root(vertex)] < most;
  }
  return floats;
}

}  // namespace

int fill_holes(ModelMesh& mesh, float widest) {
  Edges edges;
  for (const Triangle& triangle : mesh.triangles) edges.add(triangle);

  const std::vector<bool> floats = floating_vertices(mesh);
  int filled = 0;
  for (const Rim& rim : rims_of(mesh, edges)) {
    if (floats[rim.front()] || width_of(mesh, rim) > widest) continue;
    const auto triangles = RimFilling(mesh, edges, rim).triangles();
    if (!triangles) continue;

    for (const Triangle& triangle : *triangles) edges.add(triangle);
    mesh.triangles.insert(mesh.triangles.end(), triangles->begin(), triangles->end());
    ++filled;
  }
  return filled;
}

}  // namespace slipstream
