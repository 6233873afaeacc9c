#include "simulate/surface_packet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simulate/surface_packet.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "simulate/packets-inl.h"

// Plain loops over the rays of a packet, which the compiler turns into vectors of each target.
HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// Points on the rays, and unit normals against them.
void FindPoints(const PacketHits& hits, const double* origin, const LaneVectors& directions,
                PacketSurfaces& surfaces) {
  const double x = origin[0], y = origin[1], z = origin[2];
  for (int i = 0; i < packet_rays; ++i) {
    const double dx = directions.x[i], dy = directions.y[i], dz = directions.z[i];
    surfaces.point.x[i] = x + hits.distance[i] * dx;
    surfaces.point.y[i] = y + hits.distance[i] * dy;
    surfaces.point.z[i] = z + hits.distance[i] * dz;

    const double nx = hits.normal.x[i], ny = hits.normal.y[i], nz = hits.normal.z[i];
    const double length = std::sqrt(nx * nx + ny * ny + nz * nz);
    const double sign = nx * dx + ny * dy + nz * dz > 0 ? -1 : 1;
    surfaces.normal.x[i] = sign * (nx / length);
    surfaces.normal.y[i] = sign * (ny / length);
    surfaces.normal.z[i] = sign * (nz / length);
  }
}

/// Points in a body's frame, by the first three rows of a matrix of 4 x 4.
void Place(const double* m, const LaneVectors& points, LaneVectors& placed) {
  turn(m, 4, points, placed);
  const double x = m[12], y = m[13], z = m[14];
  for (int i = 0; i < packet_rays; ++i) {
    placed.x[i] += x;
    placed.y[i] += y;
    placed.z[i] += z;
  }
}

void Reflect(const PacketSurfaces& surfaces, const double* light, const double* eye,
             double more_gloss, Lanes& reflectivity) {
  const double light_x = light[0], light_y = light[1], light_z = light[2];
  const double eye_x = eye[0], eye_y = eye[1], eye_z = eye[2];

  for (int i = 0; i < packet_rays; ++i) {
    const double x = surfaces.point.x[i], y = surfaces.point.y[i], z = surfaces.point.z[i];
    const double nx = surfaces.normal.x[i], ny = surfaces.normal.y[i], nz = surfaces.normal.z[i];

    double lx = light_x - x, ly = light_y - y, lz = light_z - z;
    const double to_light = std::sqrt(lx * lx + ly * ly + lz * lz);
    lx /= to_light, ly /= to_light, lz /= to_light;
    const double cosine = std::max(0.0, nx * lx + ny * ly + nz * lz);
    const double alpha = surfaces.alpha[i] * (surfaces.lambertian[i] > 0 ? cosine : 1);

    // The highlight, where the normal is half way between the light and the eye: the cosine to the
    // 30th power.
    double ex = eye_x - x, ey = eye_y - y, ez = eye_z - z;
    const double to_eye = std::sqrt(ex * ex + ey * ey + ez * ez);
    ex = lx + ex / to_eye, ey = ly + ey / to_eye, ez = lz + ez / to_eye;
    const double half_way = std::sqrt(ex * ex + ey * ey + ez * ez);
    const double c1 = std::max(0.0, (nx * ex + ny * ey + nz * ez) / half_way);
    const double c2 = c1 * c1, c4 = c2 * c2, c8 = c4 * c4, c16 = c8 * c8;

    reflectivity[i] = std::min(std::max(alpha, 0.0), 1.0) +
                      (surfaces.gloss[i] + more_gloss) * (c16 * c8 * c4 * c2);
  }
}

void Veins(const VeinedTexture& texture, const LaneVectors& points, Lanes& alpha) {
  const double scale = texture.scale, dark = texture.darkest, bright = texture.brightest;
  Lanes inner_x, inner_y, a, b, turbulence;
  for (int i = 0; i < packet_rays; ++i) {
    inner_x[i] = 1.7 * (points.y[i] / scale);
    inner_y[i] = 2.3 * (points.z[i] / scale) + points.x[i] / scale;
  }
  sine_lanes(inner_x, inner_x);
  sine_lanes(inner_y, inner_y);

  for (int i = 0; i < packet_rays; ++i) {
    a[i] = 2.1 * (points.x[i] / scale) + 1.3 * inner_x[i];
    b[i] = 2.9 * (points.y[i] / scale) + 1.1 * inner_y[i];
  }
  sine_lanes(a, a);
  sine_lanes(b, b);

  for (int i = 0; i < packet_rays; ++i) {
    turbulence[i] = 1.5 * (points.x[i] / scale) + points.y[i] / scale + (a[i] + b[i]);
  }
  sine_lanes(turbulence, turbulence);

  for (int i = 0; i < packet_rays; ++i) {
    const double off = 1 - std::abs(turbulence[i]), off2 = off * off;
    alpha[i] = bright - (bright - dark) * (off2 * off2);
  }
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(FindPoints);
HWY_EXPORT(Place);
HWY_EXPORT(Reflect);
HWY_EXPORT(Veins);

namespace {

/// Reflectivities of a body's texture at points of its frame, for the rays that meet it.
void paint(const Texture& texture, const LaneVectors& points,
           const std::array<bool, packet_rays>& met, Lanes& alpha) {
  if (const auto* veined = texture.target<VeinedTexture>()) {
    Lanes all;
    HWY_DYNAMIC_DISPATCH(Veins)(*veined, points, all);
    for (int i = 0; i < packet_rays; ++i) alpha[i] = met[i] ? all[i] : alpha[i];
    return;
  }

  for (int i = 0; i < packet_rays; ++i) {
    if (met[i]) alpha[i] = texture(points.at(i));
  }
}

}  // namespace

PacketSurfaces surfaces_of(const std::vector<PlacedBody>& bodies, const PacketHits& hits,
                           const Eigen::Vector3d& origin, const LaneVectors& directions) {
  PacketSurfaces surfaces;
  HWY_DYNAMIC_DISPATCH(FindPoints)(hits, origin.data(), directions, surfaces);

  // Body by body, since each has its own texture.
  for (std::size_t n = 0; n < bodies.size(); ++n) {
    std::array<bool, packet_rays> met;
    bool any = false;
    for (int i = 0; i < packet_rays; ++i) {
      met[i] = hits.body[i] == static_cast<int>(n);
      any |= met[i];
    }
    if (!any) continue;

    const Body& body = *bodies[n].body;
    for (int i = 0; i < packet_rays; ++i) {
      if (!met[i]) continue;
      surfaces.lambertian[i] = body.shading == Shading::lambertian ? 1 : 0;
      surfaces.gloss[i] = body.gloss;
    }

    LaneVectors in_body;
    HWY_DYNAMIC_DISPATCH(Place)(bodies[n].to_body.matrix().data(), surfaces.point, in_body);
    paint(body.texture, in_body, met, surfaces.alpha);
  }

  return surfaces;
}

void reflect(const PacketSurfaces& surfaces, const Eigen::Vector3d& light,
             const Eigen::Vector3d& eye, double gloss, Lanes& reflectivity) {
  HWY_DYNAMIC_DISPATCH(Reflect)(surfaces, light.data(), eye.data(), gloss, reflectivity);
}

double VeinedTexture::operator()(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d q = p / scale;
  const double turbulence = std::sin(2.1 * q.x() + 1.3 * std::sin(1.7 * q.y())) +
                            std::sin(2.9 * q.y() + 1.1 * std::sin(2.3 * q.z() + q.x()));
  const double vein = std::abs(std::sin(1.5 * q.x() + q.y() + turbulence));
  return brightest - (brightest - darkest) * std::pow(1 - vein, 4);
}

}  // namespace slipstream
#endif
