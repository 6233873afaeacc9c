#pragma once

#include <vector>

#include "simulate/ray_packet.h"
#include "slipstream/scene.h"

namespace slipstream {

/// The surfaces that a packet's rays meet; those of rays without a surface are undefined.
struct PacketSurfaces {
  LaneVectors point, normal;       ///< as in SurfacePoint
  Lanes alpha, lambertian, gloss;  ///< `lambertian`: 1 or 0
};

PacketSurfaces surfaces_of(const std::vector<PlacedBody>& bodies, const PacketHits& hits,
                           const Eigen::Vector3d& origin, const LaneVectors& directions);

/// Reflectivity with shading and highlight, for light from a point seen from `eye`.
void reflect(const PacketSurfaces& surfaces, const Eigen::Vector3d& light,
             const Eigen::Vector3d& eye, double gloss, Lanes& reflectivity);

/// Reflectivities of veined_texture.
struct VeinedTexture {
  double darkest, brightest, scale;
  double operator()(const Eigen::Vector3d& p) const;
};

}  // namespace slipstream
