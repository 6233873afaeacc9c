#include "simulate/rehearsal.h"

#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "base/numbers.h"
#include "simulate/accuracy.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/virtual_world.h"

namespace slipstream {
namespace {

using Vector = Eigen::Vector3d;

bool is_in_picture(const Lens& lens, const Vector& point) {
  const Eigen::Array2d last(lens.size.width - 1, lens.size.height - 1);
  const Eigen::Array2d pixel = project(lens, point);
  return point.z() > 0 && (pixel >= 0).all() && (pixel <= last).all();
}

/// Whether both devices see all corners of a cube.
bool is_seen(const Scanner& scanner, const Vector& centre, double side) {
  for (int corner = 0; corner < 8; ++corner) {
    const Vector direction((corner & 1) - 0.5, (corner >> 1 & 1) - 0.5, (corner >> 2) - 0.5);
    const Vector point = centre + side * direction;
    if (!is_in_picture(scanner.camera, point)) return false;
    if (!is_in_picture(scanner.projector, in_projector_frame(scanner, point))) return false;
  }

  return true;
}

/// Side, mm, of the largest cube that both fully see.
double measured_cube(const Scanner& scanner) {
  const WorkingVolume volume = working_volume(scanner);
  // Shrinks by a hundredth until it fits.
  for (double side = volume.extent; side > volume.extent / 20; side *= 0.99) {
    if (is_seen(scanner, volume.centre, side)) return side;
  }

  throw Error("camera and projector see no common volume; check rotation and translation");
}

/// Two spheres and a square rod between them, along X about the origin.
Scene ball_bar(const Artefacts& artefacts, const Eigen::Isometry3d& pose) {
  const double radius = artefacts.diameters[0] / 2, reach = *artefacts.distance / 2;
  Scene scene;

  for (const double x : {-reach, reach}) {
    scene.push_back({.shape = Sphere{radius}, .pose = pose * Eigen::Translation3d(x, 0, 0)});
  }

  const double width = 0.6 * radius;
  scene.push_back({.shape = Box{{2 * reach, width, width}}, .pose = pose});

  return scene;
}

struct BarPosition {
  Vector middle, direction;  ///< middle: relative to half the free distance to the sides
};

const std::array<BarPosition, 7> bar_positions{{{{0, 0, 0}, {1, 1, 1}},
                                                {{0, 0, 0}, {-1, 1, 1}},
                                                {{0, 0, 0}, {1, -1, 1}},
                                                {{0, 0, 0}, {-1, -1, 1}},
                                                {{0, 1, -1}, {1, 0, 0}},
                                                {{1, 0, 1}, {0, 1, 0}},
                                                {{0, -1, 0}, {1, 0, 1}}}};

/// Depth of a plane's centre, relative to the cube's side, and its tilts.
struct PlanePosition {
  double depth, about_x, about_y;
};

constexpr std::array<PlanePosition, 6> plane_positions{
    {{0, 0, 0}, {-0.3, 0, 0}, {0.3, 0, 0}, {0, 30, 0}, {0, 0, 30}, {0, -20, -20}}};

using Scenes = std::map<std::string, Scene>;

void add_bars(Rehearsal& test, Scenes& scenes, const Vector& centre, double side) {
  const double diagonal = std::sqrt(3) * side;
  test.artefacts.diameters = {0.1 * diagonal, 0.1 * diagonal};
  test.artefacts.distance = 0.35 * diagonal;

  // Farthest that a sphere's centre may be from the middle plane of the cube.
  const double free = (side - test.artefacts.diameters[0]) / 2;

  for (const auto& [middle, direction] : bar_positions) {
    const Eigen::Isometry3d pose = Eigen::Translation3d(centre + free * middle) *
                                   Eigen::Quaterniond::FromTwoVectors(Vector::UnitX(), direction);

    test.artefacts.spheres.push_back(fmt::format("ball bar {}", test.artefacts.spheres.size() + 1));
    scenes[test.artefacts.spheres.back()] = ball_bar(test.artefacts, pose);
  }
}

void add_planes(Rehearsal& test, Scenes& scenes, const Vector& centre, double side) {
  const double length = 0.5 * std::sqrt(3) * side;

  for (const auto& [depth, about_x, about_y] : plane_positions) {
    const Eigen::Isometry3d pose = Eigen::Translation3d(centre + Vector(0, 0, depth * side)) *
                                   Eigen::AngleAxisd(about_y * degree, Vector::UnitY()) *
                                   Eigen::AngleAxisd(about_x * degree, Vector::UnitX());

    test.artefacts.planes.push_back(fmt::format("plane {}", test.artefacts.planes.size() + 1));
    scenes[test.artefacts.planes.back()] = {Body{.shape = Board{length, length}, .pose = pose}};
  }

  // One plane again and again, for the repeatability.
  constexpr int repeats = 10;
  for (int i = 0; i < repeats; ++i) {
    test.artefacts.repeated.push_back(fmt::format("repeat {}", i + 1));
    scenes[test.artefacts.repeated.back()] = scenes[test.artefacts.planes.front()];
  }
}

}  // namespace

Rehearsal rehearsal(const VirtualWorld& world, const Sequence& sequence, const Scanner& calibrated,
                    const ReconstructSettings& settings) {
  const double side = measured_cube(world.scanner);
  const Vector centre = working_volume(world.scanner).centre;

  Rehearsal test;
  Scenes scenes;
  add_bars(test, scenes, centre, side);
  add_planes(test, scenes, centre, side);
  test.artefacts.diagonal = std::sqrt(3) * side;

  const auto engine = std::make_shared<Engine>(calibrated, sequence, settings);
  const PatternSet patterns = pattern_set(sequence);

  // Simulates a scan whenever its cloud is needed, each time with other noise.
  test.cloud_of = [=, scene_of = std::move(scenes),
                   next = world.photometry](const std::string& scan) mutable {
    const VirtualScan taken = take_scan(world.scanner, scene_of.at(scan), patterns, next);
    ++next.seed;
    Cloud cloud;
    engine->cloud(taken.frames.views(), cloud);
    return cloud;
  };

  return test;
}

}  // namespace slipstream
