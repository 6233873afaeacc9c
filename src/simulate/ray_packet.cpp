#include "simulate/ray_packet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <variant>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simulate/ray_packet.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "simulate/packets-inl.h"
#include "simulate/triangle_tree.h"

// Plain loops over the rays of a packet, which the compiler turns into vectors of each target.
HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

void Turn(const double* m, int stride, const LaneVectors& v, LaneVectors& turned) {
  turn(m, stride, v, turned);
}

void MeetBoard(const Board& board, const double* origin, const LaneVectors& directions,
               Lanes& distance, LaneVectors& normal) {
  const double x = origin[0], y = origin[1], z = origin[2];
  const double width = board.width, height = board.height;
  for (int i = 0; i < packet_rays; ++i) {
    const double here = -z / directions.z[i];
    const double across = 2 * std::abs(x + here * directions.x[i]);
    const double down = 2 * std::abs(y + here * directions.y[i]);
    const bool inside = (here > 0) & (across <= width) & (down <= height);
    distance[i] = inside ? here : HUGE_VAL;
    normal.x[i] = normal.y[i] = 0;
    normal.z[i] = 1;
  }
}

void MeetSphere(const Sphere& sphere, const double* origin, const LaneVectors& directions,
                Lanes& distance, LaneVectors& normal) {
  const double x = origin[0], y = origin[1], z = origin[2], r2 = sphere.radius * sphere.radius;
  for (int i = 0; i < packet_rays; ++i) {
    const double dx = directions.x[i], dy = directions.y[i], dz = directions.z[i];
    const double a = dx * dx + dy * dy + dz * dz;

    // The ray's point nearest to the centre: no cancellation for far spheres.
    const double middle = -(x * dx + y * dy + z * dz) / a;
    const double px = x + middle * dx, py = y + middle * dy, pz = z + middle * dz;
    const double under_root = r2 - (px * px + py * py + pz * pz);
    const double half_chord = std::sqrt(std::max(under_root, 0.0) / a);

    // The nearer crossing, or the farther one from within the sphere.
    const double near = middle - half_chord, far = middle + half_chord;
    const double here = near > 0 ? near : far;
    distance[i] = (under_root >= 0) & (here > 0) ? here : HUGE_VAL;
    normal.x[i] = x + here * dx;
    normal.y[i] = y + here * dy;
    normal.z[i] = z + here * dz;
  }
}

void MeetBox(const Box& box, const double* origin, const LaneVectors& directions, Lanes& distance,
             LaneVectors& normal) {
  const double x = origin[0], y = origin[1], z = origin[2];
  const double* const size = box.size.data();
  const double half_x = size[0] / 2, half_y = size[1] / 2, half_z = size[2] / 2;

  for (int i = 0; i < packet_rays; ++i) {
    // Where the ray crosses each pair of faces: it enters at the last of the near crossings.
    const double dx = directions.x[i], dy = directions.y[i], dz = directions.z[i];
    const double ax = (-half_x - x) / dx, bx = (half_x - x) / dx;
    const double ay = (-half_y - y) / dy, by = (half_y - y) / dy;
    const double az = (-half_z - z) / dz, bz = (half_z - z) / dz;
    const double near_x = std::min(ax, bx), near_y = std::min(ay, by), near_z = std::min(az, bz);

    const double enter = std::max(std::max(near_x, near_y), near_z);
    const double leave = std::min(std::min(std::max(ax, bx), std::max(ay, by)), std::max(az, bz));
    distance[i] = (enter <= leave) & (enter > 0) ? enter : HUGE_VAL;
    normal.x[i] = near_x == enter ? 1 : 0;
    normal.y[i] = near_y == enter ? 1 : 0;
    normal.z[i] = near_z == enter ? 1 : 0;
  }
}

/// Keeps the hits of a body that are nearer than those before. Its normals are in the camera's
/// frame.
void KeepNearer(const Lanes& distance, const LaneVectors& normal, int body, PacketHits& hits) {
  for (int i = 0; i < packet_rays; ++i) {
    const bool nearer = distance[i] < hits.distance[i];
    hits.distance[i] = nearer ? distance[i] : hits.distance[i];
    hits.normal.x[i] = nearer ? normal.x[i] : hits.normal.x[i];
    hits.normal.y[i] = nearer ? normal.y[i] : hits.normal.y[i];
    hits.normal.z[i] = nearer ? normal.z[i] : hits.normal.z[i];
    hits.body[i] = nearer ? body : hits.body[i];
  }
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(Turn);
HWY_EXPORT(MeetBoard);
HWY_EXPORT(MeetSphere);
HWY_EXPORT(MeetBox);
HWY_EXPORT(KeepNearer);

namespace {

/// Rays in a body's frame.
struct RaysInBody {
  RaysInBody(const PlacedBody& placed, const Eigen::Vector3d& from, const LaneVectors& along)
      : origin(placed.to_body * from) {
    HWY_DYNAMIC_DISPATCH(Turn)(placed.to_body.matrix().data(), 4, along, directions);
  }

  Eigen::Vector3d origin;
  LaneVectors directions;
};

/// Where rays meet a body without triangles; infinite distances elsewhere. Normals are in the
/// body's frame.
void meet(const Shape& shape, const RaysInBody& rays, Lanes& distance, LaneVectors& normal) {
  const double* const origin = rays.origin.data();
  if (const auto* board = std::get_if<Board>(&shape)) {
    HWY_DYNAMIC_DISPATCH(MeetBoard)(*board, origin, rays.directions, distance, normal);
  } else if (const auto* sphere = std::get_if<Sphere>(&shape)) {
    HWY_DYNAMIC_DISPATCH(MeetSphere)(*sphere, origin, rays.directions, distance, normal);
  } else {
    HWY_DYNAMIC_DISPATCH(MeetBox)
    (std::get<Box>(shape), origin, rays.directions, distance, normal);
  }
}

const TriangleTree* triangles_of(const Shape& shape) {
  const auto* mesh = std::get_if<std::shared_ptr<const MeshTree>>(&shape);
  return mesh == nullptr ? nullptr : &(*mesh)->triangles();
}

}  // namespace

PacketHits first_hits(const std::vector<PlacedBody>& bodies, const Eigen::Vector3d& origin,
                      const LaneVectors& directions, const Lanes& limit) {
  PacketHits hits{.distance = limit, .normal = {}, .body = {}};
  hits.body.fill(-1);

  for (std::size_t n = 0; n < bodies.size(); ++n) {
    const PlacedBody& placed = bodies[n];
    const RaysInBody rays(placed, origin, directions);
    Lanes distance;
    LaneVectors normal;

    if (const TriangleTree* const triangles = triangles_of(placed.body->shape)) {
      distance = hits.distance;
      std::array<int, packet_rays> triangle;
      triangles->find_first(rays.origin, rays.directions, distance, triangle);
      if (distance == hits.distance) continue;
      for (int i = 0; i < packet_rays; ++i) {
        normal.set(i, triangle[i] < 0 ? Eigen::Vector3d::Zero() : triangles->normal(triangle[i]));
      }
    } else {
      meet(placed.body->shape, rays, distance, normal);
    }

    LaneVectors turned;
    HWY_DYNAMIC_DISPATCH(Turn)(placed.pose.matrix().data(), 4, normal, turned);
    HWY_DYNAMIC_DISPATCH(KeepNearer)(distance, turned, static_cast<int>(n), hits);
  }

  return hits;
}

void block(const std::vector<PlacedBody>& bodies, const Eigen::Vector3d& origin,
           const LaneVectors& directions, Lanes& limit) {
  for (const PlacedBody& placed : bodies) {
    if (std::ranges::all_of(limit, [](double l) { return l < 0; })) return;
    const RaysInBody rays(placed, origin, directions);

    if (const TriangleTree* const triangles = triangles_of(placed.body->shape)) {
      triangles->find_any(rays.origin, rays.directions, limit);
      continue;
    }

    Lanes distance;
    LaneVectors normal;
    meet(placed.body->shape, rays, distance, normal);
    for (int i = 0; i < packet_rays; ++i) limit[i] = distance[i] < limit[i] ? -1 : limit[i];
  }
}

}  // namespace slipstream
#endif
