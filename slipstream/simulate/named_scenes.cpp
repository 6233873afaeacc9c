#include "slipstream/simulate/named_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

#include "slipstream/base/did_you_mean.h"
#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/simulate/statue.h"

namespace slipstream {
namespace {

using Vector = Eigen::Vector3d;

/// What a device sees whole at that distance.
double visible_extent(const Lens& lens, double distance) {
  return distance *
         std::min(lens.size.width / lens.intrinsic(0, 0), lens.size.height / lens.intrinsic(1, 1));
}

Eigen::Isometry3d placed(const Vector& position, double about_x = 0, double about_y = 0) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(position);
  pose.rotate(Eigen::AngleAxisd(about_y, Vector::UnitY()));
  pose.rotate(Eigen::AngleAxisd(about_x, Vector::UnitX()));
  return pose;
}

/// Y up and facing +Z, as meshes are made, to upright in the camera's picture and facing the
/// camera.
constexpr double upright = std::numbers::pi;

Scene board_scene(const WorkingVolume& volume) {
  const double side = 4 * volume.extent;
  return {
      Body{.shape = Board{side, side}, .pose = placed(volume.centre, -12 * degree, 20 * degree)}};
}

Scene sphere_scene(const WorkingVolume& volume) {
  return {Body{.shape = Sphere{0.4 * volume.extent}, .pose = placed(volume.centre)}};
}

Scene boxes_scene(const WorkingVolume& volume) {
  const double side = 0.32 * volume.extent;
  const Vector offset(0.27 * volume.extent, 0, 0.25 * volume.extent);
  const Box box{Vector::Constant(side)};
  return {Body{.shape = box, .pose = placed(volume.centre - offset, 15 * degree, 25 * degree)},
          Body{.shape = box, .pose = placed(volume.centre + offset, -10 * degree, -20 * degree)}};
}

Scene statue_scene(const Scanner& scanner, const WorkingVolume& volume) {
  Scene scene = scene_with_mesh(statue(), scanner);
  scene.front().texture = veined_texture(0.35, 0.85, 0.2 * volume.extent);
  const Vector behind = volume.centre + Vector(0, 0, 0.45 * volume.extent);
  scene.push_back(Body{.shape = Board{8 * volume.extent, 8 * volume.extent},
                       .pose = placed(behind),
                       .texture = uniform_texture(0.45),
                       .shading = Shading::lambertian,
                       .fixed = true});
  return scene;
}

Scene contrast_scene(const WorkingVolume& volume) {
  const double side = 4 * volume.extent;
  const Texture wedge = [scale = 0.6 * volume.extent](const Vector& p) {
    return 0.02 * std::pow(50, std::clamp(p.x() / scale + 0.5, 0.0, 1.0));
  };
  return {Body{.shape = Board{side, side}, .pose = placed(volume.centre), .texture = wedge},
          Body{.shape = Sphere{0.2 * volume.extent},
               .pose = placed(volume.centre),
               .texture = uniform_texture(0.1),
               .gloss = 3}};
}

}  // namespace

WorkingVolume working_volume(const Scanner& scanner) {
  // The point of the camera's axis (0, 0, z) nearest to the projector's.
  const Vector centre = projector_centre(scanner);
  const Vector axis = scanner.rotation.row(2);
  const double across = 1 - axis.z() * axis.z();
  double depth = 4 * centre.norm();
  if (across > 1e-6) depth = (centre.z() - axis.z() * axis.dot(centre)) / across;
  if (depth <= 0) depth = 4 * centre.norm();
  const Vector place(0, 0, depth);
  const double extent = std::min(visible_extent(scanner.camera, depth),
                                 visible_extent(scanner.projector, (place - centre).norm()));
  return {place, 0.9 * extent};
}

Scanner example_scanner(Size camera) {
  const double camera_focal = 1.3 * camera.width;
  constexpr double projector_focal = 1500;
  const Size projector{1280, 800};
  const Vector centre(150, -110, 10), target(0, 0, 600);

  Scanner scanner;
  scanner.camera.size = camera;
  scanner.camera.intrinsic << camera_focal, 0, 0.495 * camera.width, 0, camera_focal,
      0.51 * camera.height, 0, 0, 1;
  scanner.camera.distortion = make_distortion(std::array{-0.12, 0.07, 4e-4, -6e-4, 0.0});
  scanner.projector.size = projector;
  scanner.projector.intrinsic << projector_focal, 0, 0.5 * projector.width, 0, projector_focal,
      0.52 * projector.height, 0, 0, 1;
  scanner.projector.distortion = make_distortion(std::array{-0.06, 0.03, -3e-4, 5e-4, 0.0});

  const Vector forward = (target - centre).normalized();
  const Vector right = Vector::UnitY().cross(forward).normalized();
  scanner.rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  scanner.translation = -scanner.rotation * centre;
  return scanner;
}

std::vector<std::string_view> scene_names() {
  return {"board", "sphere", "boxes", "statue", "contrast"};
}

Scene scene_named(std::string_view name, const Scanner& scanner) {
  const WorkingVolume volume = working_volume(scanner);
  if (name == "board") return board_scene(volume);
  if (name == "sphere") return sphere_scene(volume);
  if (name == "boxes") return boxes_scene(volume);
  if (name == "statue") return statue_scene(scanner, volume);
  if (name == "contrast") return contrast_scene(volume);
  throw Error(fmt::format("scene '{}' is not known; it is one of: {}{}", name,
                          fmt::join(scene_names(), ", "), did_you_mean(name, scene_names())));
}

Scene scene_with_mesh(Mesh mesh, const Scanner& scanner, double size) {
  const WorkingVolume volume = working_volume(scanner);
  Eigen::AlignedBox3d bounds;
  for (const Vector& vertex : mesh.vertices) bounds.extend(vertex);
  const double largest_side = bounds.isEmpty() ? 0 : bounds.sizes().maxCoeff();
  if (!(largest_side > 0)) throw Error("the mesh has no extent");
  const double scale = (size > 0 ? size : 0.95 * volume.extent) / largest_side;
  for (Vector& vertex : mesh.vertices) vertex = scale * (vertex - bounds.center());
  return {Body{.shape = std::make_shared<const MeshTree>(std::move(mesh)),
               .pose = placed(volume.centre, upright),
               .shading = Shading::lambertian}};
}

}  // namespace slipstream
