#include "merge/model_surface.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>

#include "base/parallel_rows.h"
#include "merge/point_grid.h"

namespace slipstream {
namespace {

using Node = Eigen::Vector3i;

/// Weighted means of the points around a place.
struct Blend {
  float distance = 0;  ///< of the place from their planes; positive outside
  float nearest = 0;   ///< distance of the nearest, mm
  ModelPoint point{};
};

/// Blends points within two spacings.
class PointBlend {
 public:
  explicit PointBlend(const FusedModel& model) : model_(model) {
    for (const ModelPoint& point : model.points) places_.push_back(point.position);
    grid_ = PointGrid(places_, reach());
  }

  /// nullopt if no point is near.
  [[nodiscard]] std::optional<Blend> at(const Eigen::Vector3f& place) const {
    Blend blend;
    float weights = 0;
    Eigen::Vector3f colour = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();
    const ModelPoint* nearest = nullptr;
    float least = reach() * reach();

    grid_.for_each_near(place, reach(), [&](std::uint32_t i, float squared) {
      const ModelPoint& point = model_.points[i];
      const float share = 1 - squared / (reach() * reach());
      const float weight = share * share * share;
      weights += weight;
      blend.distance += weight * point.normal.dot(place - point.position);
      blend.point.intensity += weight * point.intensity;
      normal += weight * point.normal;
      colour += weight * Eigen::Vector3f(point.colour.red, point.colour.green, point.colour.blue);
      if (squared < least) {
        least = squared;
        nearest = &point;
      }
    });
    if (nearest == nullptr || !(weights > 0)) return std::nullopt;

    blend.distance /= weights;
    blend.nearest = std::sqrt(least);
    blend.point.position = place;
    blend.point.normal = normal.normalized();
    blend.point.intensity /= weights;
    const auto level = [&](float sum) { return grey_level(sum / weights); };
    blend.point.colour = {level(colour.x()), level(colour.y()), level(colour.z())};
    blend.point.sigma = nearest->sigma;
    blend.point.disagreement = nearest->disagreement;
    blend.point.views = nearest->views;
    return blend;
  }

 private:
  [[nodiscard]] float reach() const { return 2 * model_.spacing; }

  const FusedModel& model_;
  std::vector<Eigen::Vector3f> places_{};
  PointGrid grid_{};
};

/// Signed distances at the nodes of a grid near the points.
class DistanceGrid {
 public:
  DistanceGrid(const FusedModel& model, const PointBlend& blend) : spacing_(model.spacing) {
    if (model.points.empty()) return;
    origin_ = model.points.front().position;
    for (const ModelPoint& point : model.points) origin_ = origin_.cwiseMin(point.position);

    // 1. Nodes around each point.
    for (const ModelPoint& point : model.points) {
      const Node corner = ((point.position - origin_) / spacing_).array().floor().cast<int>();
      for (int x = -1; x <= 2; ++x) {
        for (int y = -1; y <= 2; ++y) {
          for (int z = -1; z <= 2; ++z) {
            const Node node = corner + Node(x, y, z);
            if (index_.try_emplace(cell_key(node), nodes_.size()).second) nodes_.push_back(node);
          }
        }
      }
    }

    // 2. Their distances.
    distances_.resize(nodes_.size());
    for_each_row(static_cast<int>(nodes_.size()), [&](int row) {
      const auto i = static_cast<std::size_t>(row);
      if (const auto here = blend.at(place_of(nodes_[i]))) distances_[i] = here->distance;
    });
  }

  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }
  [[nodiscard]] Eigen::Vector3f place_of(const Node& node) const {
    return origin_ + spacing_ * node.cast<float>();
  }
  /// nullopt if no point is near.
  [[nodiscard]] std::optional<float> distance(const Node& node) const {
    const auto found = index_.find(cell_key(node));
    return found == index_.end() ? std::nullopt : distances_[found->second];
  }

 private:
  float spacing_;
  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();
  std::unordered_map<std::uint64_t, std::size_t> index_{};
  std::vector<Node> nodes_{};
  std::vector<std::optional<float>> distances_{};
};

Node corner_of(const Node& cell, int corner) {
  return cell + Node(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
}

/// Mean of the places where the surface crosses the cell's edges; nullopt if it does not, or a
/// corner has no distance.
std::optional<Eigen::Vector3f> crossing_of(const DistanceGrid& grid, const Node& cell) {
  std::array<float, 8> distances{};
  for (int corner = 0; corner < 8; ++corner) {
    const auto here = grid.distance(corner_of(cell, corner));
    if (!here) return std::nullopt;
    distances[static_cast<std::size_t>(corner)] = *here;
  }

  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float crossings = 0;
  for (int from = 0; from < 8; ++from) {
    for (const int bit : {1, 2, 4}) {
      const int to = from | bit;
      const float a = distances[static_cast<std::size_t>(from)];
      const float b = distances[static_cast<std::size_t>(to)];
      if (to == from || (a < 0) == (b < 0)) continue;
      const Eigen::Vector3f start = grid.place_of(corner_of(cell, from));
      const Eigen::Vector3f end = grid.place_of(corner_of(cell, to));
      sum += start + a / (a - b) * (end - start);
      ++crossings;
    }
  }
  if (crossings == 0) return std::nullopt;
  return sum / crossings;
}

/// Removes the vertices that are not a corner of a triangle.
void drop_unused_vertices(ModelMesh& mesh) {
  constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();

  std::vector<std::uint32_t> place(mesh.vertices.size(), unused);
  std::vector<ModelPoint> used;
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& corner : triangle) {
      if (place[corner] == unused) {
        place[corner] = static_cast<std::uint32_t>(used.size());
        used.push_back(mesh.vertices[corner]);
      }
      corner = place[corner];
    }
  }
  mesh.vertices = std::move(used);
}

}  // namespace

ModelMesh mesh_of(const FusedModel& model) {
  constexpr float farthest = 1.2F;  // of a vertex from the nearest point, spacings

  ModelMesh mesh{.coloured = model.coloured, .frame = model.frame};
  const PointBlend blend(model);
  const DistanceGrid grid(model, blend);

  // 1. A vertex in each cell through which the surface goes. Far from the points the distance has
  // other zeros.
  std::unordered_map<std::uint64_t, std::uint32_t> vertex_of;
  for (const Node& cell : grid.nodes()) {
    const auto place = crossing_of(grid, cell);
    if (!place) continue;
    const auto here = blend.at(*place);
    if (!here || here->nearest > farthest * model.spacing) continue;
    vertex_of.emplace(cell_key(cell), static_cast<std::uint32_t>(mesh.vertices.size()));
    mesh.vertices.push_back(here->point);
  }

  // 2. Two triangles across each edge of the grid that the surface crosses, between the vertices of
  // the four cells around it.
  for (const Node& node : grid.nodes()) {
    const auto here = grid.distance(node);
    for (int axis = 0; axis < 3 && here; ++axis) {
      const auto there = grid.distance(node + Node::Unit(axis));
      if (!there || (*here < 0) == (*there < 0)) continue;

      const Node u = Node::Unit((axis + 1) % 3), v = Node::Unit((axis + 2) % 3);
      std::array<std::uint32_t, 4> corners{};
      bool whole = true;
      const std::array<Node, 4> cells{node, Node(node - u), Node(node - u - v), Node(node - v)};
      for (std::size_t k = 0; k < 4 && whole; ++k) {
        const auto found = vertex_of.find(cell_key(cells[k]));
        whole = found != vertex_of.end();
        if (whole) corners[k] = found->second;
      }
      if (!whole) continue;

      // Outside is where the distance is positive.
      if (*here >= 0) std::swap(corners[1], corners[3]);
      mesh.triangles.push_back({corners[0], corners[1], corners[2]});
      mesh.triangles.push_back({corners[0], corners[2], corners[3]});
    }
  }

  drop_unused_vertices(mesh);
  return mesh;
}

}  // namespace slipstream
