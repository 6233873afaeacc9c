#pragma once

#include <array>
#include <vector>

#include "slipstream/scene.h"

namespace slipstream {

/// Rays that are traced together, from one origin.
inline constexpr int packet_rays = 16;

/// One number for each ray of a packet.
struct alignas(64) Lanes : std::array<double, packet_rays> {};

/// One vector for each ray of a packet.
struct LaneVectors {
  Lanes x, y, z;

  [[nodiscard]] Eigen::Vector3d at(int ray) const { return {x[ray], y[ray], z[ray]}; }
  void set(int ray, const Eigen::Vector3d& v) { x[ray] = v.x(), y[ray] = v.y(), z[ray] = v.z(); }
};

/// Where a packet's rays meet their first surfaces.
struct PacketHits {
  Lanes distance;                       ///< infinite without a surface
  LaneVectors normal;                   ///< in the camera's frame, of any length and sign
  std::array<int, packet_rays> body{};  ///< index, -1 without a surface
};

/// `limit`: distances within which surfaces are searched; rays with a negative one are left out.
PacketHits first_hits(const std::vector<PlacedBody>& bodies, const Eigen::Vector3d& origin,
                      const LaneVectors& directions, const Lanes& limit);

/// The limit of a ray from the light to a point, in units of its length. The point's own surface is
/// at distance 1, within rounding.
inline constexpr double own_surface = 1 - 1e-6;

/// Sets the limit of the rays that meet a surface before it to -1.
void block(const std::vector<PlacedBody>& bodies, const Eigen::Vector3d& origin,
           const LaneVectors& directions, Lanes& limit);

}  // namespace slipstream
