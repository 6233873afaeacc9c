#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "merge/view.h"
#include "simulate/sculptures.h"
#include "slipstream/cloud.h"
#include "slipstream/scene.h"

// Views of a virtual object, as depth and noise alone make them.
namespace slipstream {

inline Eigen::Isometry3d turned(const Eigen::Vector3d& axis, double degrees) {
  return Eigen::Isometry3d(Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis.normalized()));
}

/// Pose of an object 600 mm in front of the camera, its Y axis up, after a turn.
inline Eigen::Isometry3d before_camera(const Eigen::Isometry3d& turn) {
  return Eigen::Translation3d(0, 0, 600) * turn * turned(Eigen::Vector3d::UnitX(), 180);
}

/// The bust, 180 mm high.
inline Mesh large_statue() {
  Mesh mesh = statue();
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex *= 180;
  return mesh;
}

/// A surface z(x, y), 200 mm wide, that faces the camera.
template <class Height>
Mesh plate(const Height& height) {
  Mesh mesh;
  append_surface(mesh, 200, 200, [&](double u, double v) {
    const double x = 200 * (u - 0.5), y = 200 * (v - 0.5);
    return Eigen::Vector3d(x, y, height(x, y));
  });
  return mesh;
}

/// `bend`: how far its sides are bent from the middle, mm.
inline Mesh relief(double bend = 0) {
  return plate([bend](double x, double y) {
    const double bump = std::exp(-(std::pow(x - 30, 2) + std::pow(y + 20, 2)) / 300);
    return 6 * std::sin(x / 17 + y / 31) * std::cos(y / 23) + 5 * bump + 3 * std::sin(x * y / 900) +
           bend * x * x / 10000;
  });
}

/// A cover with two rows of four equal bores; a rib and a boss tell its ends apart.
inline Mesh engine_part() {
  return plate([](double x, double y) {
    double z = 0;
    for (const double row : {-40, 40}) {
      for (const double column : {-75, -25, 25, 75}) {
        const double apart = std::hypot(x - column, y - row);
        z = std::max(z, std::clamp(2 * (17 - apart), 0.0, 12.0));
      }
    }
    const double rib = std::clamp(8 - std::abs(y - 0.15 * x), 0.0, 5.0);
    const double boss = std::clamp(22 - std::hypot(x - 50, y), 0.0, 14.0);
    return std::max(rib, boss) - z;
  });
}

/// Three boxes of different sizes on a table, 200 mm wide, tilted so that their sides are seen.
inline Mesh boxes() {
  Mesh mesh;
  const auto append_quad = [&](const Eigen::Vector3d& corner, const Eigen::Vector3d& along,
                               const Eigen::Vector3d& across) {
    append_surface(mesh, 1, 1, [&](double u, double v) -> Eigen::Vector3d {
      return corner + u * along + v * across;
    });
  };
  append_quad({-100, -100, 0}, {200, 0, 0}, {0, 200, 0});

  struct Placed {
    double x, y, turn, width, depth, height;
  };
  for (const auto& [x, y, turn, width, depth, height] :
       {Placed{-50, 35, 0.3, 60, 40, 30}, {40, 45, -0.5, 45, 50, 45}, {10, -45, 0.9, 70, 30, 20}}) {
    const Eigen::Vector3d along(width * std::cos(turn), width * std::sin(turn), 0);
    const Eigen::Vector3d across(-depth * std::sin(turn), depth * std::cos(turn), 0);
    const Eigen::Vector3d up(0, 0, height);
    const Eigen::Vector3d corner = Eigen::Vector3d(x, y, 0) - (along + across) / 2;
    append_quad(corner + up, along, across);
    append_quad(corner, along, up);
    append_quad(corner + across, along, up);
    append_quad(corner, across, up);
    append_quad(corner + along, across, up);
  }
  const Eigen::Isometry3d tilt = turned({1, 0.4, 0}, 35);
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex = tilt * vertex;
  return mesh;
}

/// A dished plate with `count` equal cones around its middle.
inline Mesh ring_of_cones(int count) {
  return plate([count](double x, double y) {
    double z = 0.002 * (x * x + y * y);
    for (int k = 0; k < count; ++k) {
      const double angle = 2 * std::numbers::pi * k / count;
      const double apart = std::hypot(x - 60 * std::cos(angle), y - 60 * std::sin(angle));
      z -= std::max(25 - apart, 0.0);
    }
    return z;
  });
}

inline Mesh ball() {
  Mesh mesh;
  append_surface(mesh, 100, 200, [](double u, double v) -> Eigen::Vector3d {
    const double t = std::numbers::pi * u, p = 2 * std::numbers::pi * v;
    return 80 * Eigen::Vector3d(std::sin(t) * std::cos(p), std::cos(t), std::sin(t) * std::sin(p));
  });
  return mesh;
}

inline Mesh pipe() {
  Mesh mesh;
  append_surface(mesh, 2, 200, [](double u, double v) {
    const double p = 2 * std::numbers::pi * v;
    return Eigen::Vector3d(60 * std::cos(p), 800 * (u - 0.5), 60 * std::sin(p));
  });
  return mesh;
}

/// A cloud and the standard deviations of its points.
struct Shot {
  Cloud cloud;
  Uncertainty uncertainty;
};

/// What a camera sees of an object at `pose`, with noise of depth of about `noise` mm, more on
/// slanted surface.
inline Shot shot_of(const MeshTree& object, const Eigen::Isometry3d& pose, double noise,
                    unsigned seed, Size size = {240, 180}) {
  constexpr double least_facing = 0.2;

  Shot shot{Cloud(size), Uncertainty(size)};
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const Scene scene{Body{.shape = std::make_shared<const MeshTree>(object), .pose = pose}};
  const std::vector<PlacedBody> bodies = placed_at(scene, 0);
  const double focal = 1.3 * size.width;

  for_each_pixel_in_order(size, [&](int column, int row) {
    const Eigen::Vector3d ray((column - size.width / 2.0) / focal,
                              (row - size.height / 2.0) / focal, 1);
    const auto hit = first_surface(bodies, {Eigen::Vector3d::Zero(), ray});
    if (!hit) return;
    const double facing = std::abs(hit->normal.dot(ray.normalized()));
    if (facing < least_facing) return;

    const double sigma = noise * (0.6 + 0.4 / facing);
    const Eigen::Vector3d point = (hit->distance + sigma * normal(random)) * ray;
    shot.cloud.x(column, row) = static_cast<float>(point.x());
    shot.cloud.y(column, row) = static_cast<float>(point.y());
    shot.cloud.z(column, row) = static_cast<float>(point.z());
    shot.cloud.intensity(column, row) = 100;
    shot.cloud.validity(column, row) = Validity::valid;
    shot.uncertainty.z(column, row) = static_cast<float>(sigma);
  });
  return shot;
}

inline View view_at(const MeshTree& object, const Eigen::Isometry3d& pose, double noise,
                    unsigned seed, const std::string& name = "view", Size size = {240, 180}) {
  const Shot shot = shot_of(object, pose, noise, seed, size);
  return view_of(shot.cloud, &shot.uncertainty, name);
}

}  // namespace slipstream
