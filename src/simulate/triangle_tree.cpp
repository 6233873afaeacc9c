#include "simulate/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simulate/triangle_tree.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "simulate/packets-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

using BoxTag = hn::CappedTag<float, packet_rays>;

/// What boxes are compared with. Floats are enough for boxes that err on the large side.
struct BoxRays {
  alignas(64) float inverse[3][packet_rays];  // NOLINT(modernize-avoid-c-arrays)
  alignas(64) float farthest[packet_rays];    // NOLINT(modernize-avoid-c-arrays)
};

HWY_INLINE void set_inverse(const Lanes& direction, float* inverse) {
  constexpr double smallest = 1e-30;  // its inverse is finite
  for (int i = 0; i < packet_rays; ++i) {
    const double d = direction[i], size = d < 0 ? -d : d;
    const double from_zero = size > smallest ? d : (d < 0 ? -smallest : smallest);
    inverse[i] = static_cast<float>(1 / from_zero);
  }
}

HWY_INLINE void set_farthest(const Lanes& distance, float* farthest) {
  for (int i = 0; i < packet_rays; ++i) farthest[i] = static_cast<float>(distance[i]);
}

/// Whether any ray meets the box before its farthest distance.
HWY_INLINE bool meets_box(const TreeNode& node, const double* origin, const BoxRays& rays) {
  const BoxTag d;
  const auto slack = hn::Set(d, 1 + 1e-6F);  // several times the rounding below

  const auto from = [&](const std::array<float, 3>& side, int axis) SLIPSTREAM_STEP {
    return hn::Set(d, static_cast<float>(double{side[axis]} - origin[axis]));
  };
  const auto low_x = from(node.low, 0), low_y = from(node.low, 1), low_z = from(node.low, 2);
  const auto high_x = from(node.high, 0), high_y = from(node.high, 1), high_z = from(node.high, 2);

  for (int i = 0; i < packet_rays; i += static_cast<int>(hn::Lanes(d))) {
    const auto x = hn::Load(d, rays.inverse[0] + i), y = hn::Load(d, rays.inverse[1] + i),
               z = hn::Load(d, rays.inverse[2] + i);
    const auto ax = hn::Mul(low_x, x), bx = hn::Mul(high_x, x);
    const auto ay = hn::Mul(low_y, y), by = hn::Mul(high_y, y);
    const auto az = hn::Mul(low_z, z), bz = hn::Mul(high_z, z);

    const auto enter =
        hn::Max(hn::Max(hn::Min(ax, bx), hn::Min(ay, by)), hn::Max(hn::Min(az, bz), hn::Zero(d)));
    const auto leave = hn::Min(hn::Min(hn::Max(ax, bx), hn::Max(ay, by)),
                               hn::Min(hn::Max(az, bz), hn::Load(d, rays.farthest + i)));
    if (!hn::AllFalse(d, hn::Le(enter, hn::Mul(leave, slack)))) return true;
  }

  return false;
}

/// Compares the rays with one triangle; true if it is nearer for any. `any`: see find_any.
template <bool any>
HWY_INLINE bool meet_triangle(const TreeTriangle& triangle, const double* origin,
                              const LaneVectors& directions, Lanes& distance, double number,
                              Lanes& numbers) {
  constexpr double edge = 1e-12;  // share of a side by which no ray slips between two triangles
  const LaneTag d;
  using Vector = hn::Vec<LaneTag>;

  // From the common origin, the plane and two of the edges have the same equations for all rays.
  const double* const n = triangle.normal.data();
  const double* const a = triangle.side_a.data();
  const double* const b = triangle.side_b.data();
  const double* const corner = triangle.corner.data();
  const std::array<double, 3> c{corner[0] - origin[0], corner[1] - origin[1],
                                corner[2] - origin[2]};
  const double offset = c[0] * n[0] + c[1] * n[1] + c[2] * n[2];

  const auto dot = [&](double x, double y, double z, int i) SLIPSTREAM_STEP {
    return hn::MulAdd(hn::Set(d, z), hn::Load(d, directions.z.data() + i),
                      hn::MulAdd(hn::Set(d, y), hn::Load(d, directions.y.data() + i),
                                 hn::Mul(hn::Set(d, x), hn::Load(d, directions.x.data() + i))));
  };

  bool found = false;
  for (int i = 0; i < packet_rays; i += static_cast<int>(hn::Lanes(d))) {
    // 1. Whether the ray passes within the triangle: coordinates along two sides, times the square
    //    of `facing`.
    const Vector facing = dot(n[0], n[1], n[2], i);
    const Vector along_a = hn::Mul(facing, dot(b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2],
                                               b[0] * c[1] - b[1] * c[0], i));
    const Vector along_b = hn::Mul(facing, dot(c[1] * a[2] - c[2] * a[1], c[2] * a[0] - c[0] * a[2],
                                               c[0] * a[1] - c[1] * a[0], i));
    const Vector square = hn::Mul(facing, facing);
    const auto in_triangle =
        hn::And(hn::Ge(hn::Min(along_a, along_b), hn::Mul(square, hn::Set(d, -edge))),
                hn::Le(hn::Add(along_a, along_b), hn::Mul(square, hn::Set(d, 1 + edge))));
    const auto before_ray = hn::Gt(hn::Mul(facing, hn::Set(d, offset)), hn::Zero(d));
    const auto within = hn::And(in_triangle, before_ray);
    if (hn::AllFalse(d, within)) continue;

    // 2. Whether it is nearer.
    const Vector before = hn::Load(d, distance.data() + i);
    const Vector here = hn::Div(hn::Set(d, offset), facing);
    const auto nearer = hn::And(within, hn::Lt(here, before));
    if (hn::AllFalse(d, nearer)) continue;

    found = true;
    hn::Store(hn::IfThenElse(nearer, any ? hn::Set(d, -1) : here, before), d, distance.data() + i);
    if constexpr (!any) {
      hn::Store(hn::IfThenElse(nearer, hn::Set(d, number), hn::Load(d, numbers.data() + i)), d,
                numbers.data() + i);
    }
  }

  return found;
}

template <bool any>
HWY_INLINE void trace(const TreeNode* nodes, const TreeTriangle* triangles, const double* origin,
                      const LaneVectors& directions, Lanes& distance, Lanes& numbers) {
  BoxRays rays;
  set_inverse(directions.x, rays.inverse[0]);
  set_inverse(directions.y, rays.inverse[1]);
  set_inverse(directions.z, rays.inverse[2]);
  set_farthest(distance, rays.farthest);

  std::int32_t waiting[64];  // NOLINT(modernize-avoid-c-arrays)
  int count = 0;
  waiting[count++] = 0;

  while (count > 0) {
    const std::int32_t index = waiting[--count];
    const TreeNode& node = nodes[index];
    if (!meets_box(node, origin, rays)) continue;

    // The box that the packet's first ray enters first is searched first.
    if (node.count == 0) {
      const bool backwards = rays.inverse[node.axis][0] < 0;
      waiting[count++] = backwards ? index + 1 : node.next;
      waiting[count++] = backwards ? node.next : index + 1;
      continue;
    }

    bool found = false;
    for (std::int32_t i = node.next; i < node.next + node.count; ++i) {
      found |= meet_triangle<any>(triangles[i], origin, directions, distance, i, numbers);
    }
    if (found) set_farthest(distance, rays.farthest);
  }
}

void FindFirst(const TreeNode* nodes, const TreeTriangle* triangles, const double* origin,
               const LaneVectors& directions, Lanes& distance, Lanes& numbers) {
  trace<false>(nodes, triangles, origin, directions, distance, numbers);
}

void FindAny(const TreeNode* nodes, const TreeTriangle* triangles, const double* origin,
             const LaneVectors& directions, Lanes& distance, Lanes& numbers) {
  trace<true>(nodes, triangles, origin, directions, distance, numbers);
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include "base/throw_if-inl.h"

namespace slipstream {

HWY_EXPORT(FindFirst);
HWY_EXPORT(FindAny);

namespace {

constexpr std::int16_t leaf_triangles = 4;

/// A triangle while the tree is built.
struct Leaf {
  Eigen::Array3f low, high, centre;
  int index = 0;
};

Leaf leaf_of(const Mesh& mesh, int index) {
  Leaf leaf;
  leaf.index = index;

  Eigen::AlignedBox3d box;
  for (const int corner : mesh.triangles[index]) {
    throw_if(corner < 0 || static_cast<std::size_t>(corner) >= mesh.vertices.size(),
             "a triangle of the mesh refers to vertex {} of {}", corner, mesh.vertices.size());
    box.extend(mesh.vertices[corner]);
  }

  // Rounded outwards.
  constexpr float infinity = std::numeric_limits<float>::infinity();
  for (int k = 0; k < 3; ++k) {
    leaf.low[k] = std::nextafter(static_cast<float>(box.min()[k]), -infinity);
    leaf.high[k] = std::nextafter(static_cast<float>(box.max()[k]), infinity);
  }
  leaf.centre = (leaf.low + leaf.high) / 2;

  return leaf;
}

/// Appends the node of leaves `first` to before `last`, and those below it.
void append_node(std::vector<Leaf>& leaves, int first, int last, std::vector<TreeNode>& nodes) {
  const Leaf& one = leaves[first];
  Eigen::Array3f low = one.low, high = one.high, nearest = one.centre, farthest = one.centre;
  for (int i = first + 1; i < last; ++i) {
    low = low.min(leaves[i].low);
    high = high.max(leaves[i].high);
    nearest = nearest.min(leaves[i].centre);
    farthest = farthest.max(leaves[i].centre);
  }

  const std::size_t here = nodes.size();
  nodes.push_back({{low[0], low[1], low[2]}, {high[0], high[1], high[2]}, first});
  if (last - first <= leaf_triangles) {
    nodes[here].count = static_cast<std::int16_t>(last - first);
    return;
  }

  // Two halves along the longest side.
  int axis = 0;
  (farthest - nearest).maxCoeff(&axis);
  const int middle = (first + last) / 2;
  std::nth_element(
      leaves.begin() + first, leaves.begin() + middle, leaves.begin() + last,
      [axis](const Leaf& a, const Leaf& b) { return a.centre[axis] < b.centre[axis]; });

  nodes[here].axis = static_cast<std::int16_t>(axis);
  append_node(leaves, first, middle, nodes);
  nodes[here].next = static_cast<std::int32_t>(nodes.size());
  append_node(leaves, middle, last, nodes);
}

/// Perpendicular to a triangle, as long as twice its area. Zero, which no ray meets, if both sides
/// have the same direction within rounding: their cross product would be rounding alone.
Eigen::Vector3d normal_of(const Eigen::Vector3d& side_a, const Eigen::Vector3d& side_b) {
  constexpr double least_sine = 1e-12;

  const Eigen::Vector3d normal = side_a.cross(side_b);
  const bool has_area = normal.norm() > least_sine * side_a.norm() * side_b.norm();
  if (!has_area) return Eigen::Vector3d::Zero();
  return normal;
}

}  // namespace

TriangleTree::TriangleTree(const Mesh& mesh) {
  if (mesh.triangles.empty()) throw Error("the mesh has no triangles");

  const int count = static_cast<int>(mesh.triangles.size());
  std::vector<Leaf> leaves;
  leaves.reserve(count);
  for (int i = 0; i < count; ++i) leaves.push_back(leaf_of(mesh, i));
  append_node(leaves, 0, count, nodes_);

  triangles_.reserve(count);
  for (const Leaf& leaf : leaves) {
    const auto& [i, j, k] = mesh.triangles[leaf.index];
    const Eigen::Vector3d& corner = mesh.vertices[i];
    const Eigen::Vector3d side_a = mesh.vertices[j] - corner, side_b = mesh.vertices[k] - corner;
    triangles_.push_back({corner, side_a, side_b, normal_of(side_a, side_b)});
  }
}

void TriangleTree::find_first(const Eigen::Vector3d& origin, const LaneVectors& directions,
                              Lanes& distance, std::array<int, packet_rays>& triangle) const {
  Lanes numbers;
  numbers.fill(-1);
  HWY_DYNAMIC_DISPATCH(FindFirst)
  (nodes_.data(), triangles_.data(), origin.data(), directions, distance, numbers);
  std::ranges::transform(numbers, triangle.begin(), [](double n) { return static_cast<int>(n); });
}

void TriangleTree::find_any(const Eigen::Vector3d& origin, const LaneVectors& directions,
                            Lanes& distance) const {
  Lanes numbers;
  HWY_DYNAMIC_DISPATCH(FindAny)
  (nodes_.data(), triangles_.data(), origin.data(), directions, distance, numbers);
}

}  // namespace slipstream
#endif
