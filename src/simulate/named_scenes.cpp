#include "slipstream/named_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "simulate/hand.h"
#include "simulate/sculptures.h"

namespace slipstream {
namespace {

using std::numbers::pi;
using Vector = Eigen::Vector3d;

/// Extent of a device's field at a distance.
double visible_extent(const Lens& lens, double distance) {
  return distance *
         std::min(lens.size.width / lens.intrinsic(0, 0), lens.size.height / lens.intrinsic(1, 1));
}

Eigen::Isometry3d placed(const Vector& position, double about_x = 0, double about_y = 0) {
  return Eigen::Translation3d(position) * Eigen::AngleAxisd(about_y, Vector::UnitY()) *
         Eigen::AngleAxisd(about_x, Vector::UnitX());
}

/// Rotation about X from a mesh's Y up, facing +Z, to upright in the picture, facing the camera.
constexpr double upright = std::numbers::pi;

Scene boxes_scene(const WorkingVolume& volume) {
  const double side = 0.32 * volume.extent;
  const Vector offset(0.27 * volume.extent, 0, 0.25 * volume.extent);
  const Box box{Vector::Constant(side)};
  return {Body{.shape = box, .pose = placed(volume.centre - offset, 15 * degree, 25 * degree)},
          Body{.shape = box, .pose = placed(volume.centre + offset, -10 * degree, -20 * degree)}};
}

Scene statue_scene(const Scanner& scanner, const WorkingVolume& volume) {
  // The statue before a wall.
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

Scene hand_scene(const WorkingVolume& volume) {
  Scene scene = hand(0.72 * volume.extent, placed(volume.centre, upright));

  // A white box behind it, for contrast.
  const Vector box = volume.extent * Vector(0.9, 0.8, 0.3);
  scene.push_back(
      Body{.shape = Box{box},
           .pose = placed(volume.centre + Vector(0, 0, 0.6 * volume.extent), 0, 15 * degree),
           .texture = uniform_texture(0.85),
           .shading = Shading::lambertian,
           .fixed = true});

  return scene;
}

Scene angel_scene(const Scanner& scanner, const WorkingVolume& volume) {
  Scene scene = scene_with_mesh(angel(), scanner);
  scene.front().texture = veined_texture(0.35, 0.85, 0.12 * volume.extent);
  return scene;
}

Scene fish_scene(const Scanner& scanner, const WorkingVolume& volume) {
  const double length = 0.95 * volume.extent;
  Scene scene = scene_with_mesh(fish(), scanner, length);
  scene.front().texture = fish_paint(length);

  // The grey board that it lies on.
  const Vector behind = volume.centre + Vector(0, 0, 0.09 * length);
  scene.push_back(Body{.shape = Board{8 * volume.extent, 8 * volume.extent},
                       .pose = placed(behind),
                       .texture = uniform_texture(0.5),
                       .shading = Shading::lambertian,
                       .fixed = true});

  return scene;
}

Scene contrast_scene(const WorkingVolume& volume) {
  const double side = 4 * volume.extent;
  // From 0.02 to 1 across the view: equal ratios at equal distances.
  const Texture wedge = [scale = 0.6 * volume.extent](const Vector& p) {
    return 0.02 * std::pow(50, std::clamp(p.x() / scale + 0.5, 0.0, 1.0));
  };

  return {Body{.shape = Board{side, side}, .pose = placed(volume.centre), .texture = wedge},
          Body{.shape = Sphere{0.2 * volume.extent},
               .pose = placed(volume.centre),
               .texture = uniform_texture(0.1),
               .gloss = 3}};
}

bool in_picture(const Lens& lens, const Eigen::Vector3d& point) {
  constexpr double margin = 0.01;  // of the picture
  const Eigen::Array2d size(lens.size.width, lens.size.height), pixel = project(lens, point);
  return point.z() > 0 && (pixel > margin * size).all() && (pixel < (1 - margin) * size).all();
}

bool seen_whole(const Scanner& scanner, const Eigen::Isometry3d& pose, double width,
                double height) {
  // Its corners, the middles of its sides and its centre.
  bool seen = true;
  for_each_pixel_in_order({3, 3}, [&](int x, int y) {
    const Vector point = pose * Vector((0.5 * x - 0.5) * width, (0.5 * y - 0.5) * height, 0);
    seen = seen && in_picture(scanner.camera, point) &&
           in_picture(scanner.projector, in_projector_frame(scanner, point));
  });

  return seen;
}

/// Pose `i`, moved from the centre by `shift` in its own direction.
Eigen::Isometry3d pose_number(int i, const WorkingVolume& volume, double shift) {
  constexpr double golden_angle = 2.399963;  // rad: every pose gets its own tilt and direction
  const double lean_direction = golden_angle * i;
  const double lean = (15 + 20 * std::fmod(0.618 * i, 1.0)) * degree;
  const double nearness = 1 + 0.12 * std::cos(2.1 * i);
  const double spin = 12 * degree * std::sin(1.3 * i);
  const double move_direction = golden_angle * i * 2 + 0.7;

  const auto sideways = [](double direction) {
    return Eigen::Vector3d(std::cos(direction), std::sin(direction), 0);
  };

  return Eigen::Translation3d(volume.centre * nearness + shift * sideways(move_direction)) *
         Eigen::AngleAxisd(lean, sideways(lean_direction)) *
         Eigen::AngleAxisd(spin, Eigen::Vector3d::UnitZ());
}

}  // namespace

WorkingVolume working_volume(const Scanner& scanner) {
  // The point of the camera's axis (0, 0, z) nearest to the projector's axis.
  const Vector centre = projector_centre(scanner);
  const Vector axis = scanner.rotation.row(2);

  const double across = 1 - axis.z() * axis.z();
  double depth = across > 1e-6 ? (centre.z() - axis.z() * axis.dot(centre)) / across : 0;
  // If the axes are parallel, or meet behind the camera, assume a depth of four baselines.
  if (depth <= 0) depth = 4 * centre.norm();

  const Vector place(0, 0, depth);
  const double extent = std::min(visible_extent(scanner.camera, depth),
                                 visible_extent(scanner.projector, (place - centre).norm()));
  return {place, 0.9 * extent};
}

Eigen::Matrix3d looking_along(const Vector& direction) {
  const Vector forward = direction.normalized();
  const Vector right = Vector::UnitY().cross(forward).normalized();
  Eigen::Matrix3d rotation;
  rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  return rotation;
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

  scanner.rotation = looking_along(target - centre);
  scanner.translation = -scanner.rotation * centre;
  return scanner;
}

std::vector<std::string_view> scene_names() {
  return {"board", "sphere", "boxes", "statue", "contrast", "hand", "angel", "fish"};
}

Scene scene_named(std::string_view name, const Scanner& scanner) {
  const WorkingVolume volume = working_volume(scanner);

  if (name == "board") {
    const Board board{4 * volume.extent, 4 * volume.extent};
    return {Body{.shape = board, .pose = placed(volume.centre, -12 * degree, 20 * degree)}};
  }
  if (name == "sphere")
    return {Body{.shape = Sphere{0.4 * volume.extent}, .pose = placed(volume.centre)}};
  if (name == "boxes") return boxes_scene(volume);
  if (name == "statue") return statue_scene(scanner, volume);
  if (name == "contrast") return contrast_scene(volume);
  if (name == "hand") return hand_scene(volume);
  if (name == "angel") return angel_scene(scanner, volume);
  if (name == "fish") return fish_scene(scanner, volume);

  throw Error(fmt::format("scene '{}' is not known; expected one of: {}{}", name,
                          fmt::join(scene_names(), ", "), did_you_mean(name, scene_names())));
}

Scene scene_with_mesh(Mesh mesh, const Scanner& scanner, double size) {
  const WorkingVolume volume = working_volume(scanner);

  // The mesh's largest side fills the volume, or has the given size.
  Eigen::AlignedBox3d bounds;
  for (const Vector& vertex : mesh.vertices) bounds.extend(vertex);
  const double largest_side = bounds.isEmpty() ? 0 : bounds.sizes().maxCoeff();
  if (!(largest_side > 0)) throw Error("the mesh has no extent");

  const double scale = (size > 0 ? size : 0.95 * volume.extent) / largest_side;
  for (Vector& vertex : mesh.vertices) vertex = scale * (vertex - bounds.center());

  return {Body{.shape = std::make_shared<const MeshTree>(mesh),
               .pose = placed(volume.centre, upright),
               .shading = Shading::lambertian}};
}

std::vector<Eigen::Isometry3d> board_poses(const Scanner& scanner, int count, double width,
                                           double height) {
  const WorkingVolume volume = working_volume(scanner);
  std::vector<Eigen::Isometry3d> poses;

  for (int i = 0; i < count; ++i) {
    throw_if(!seen_whole(scanner, pose_number(i, volume, 0), width, height),
             "a board of {:.4g}x{:.4g} mm does not fit into the scanner's view of about {:.4g} mm; "
             "use a smaller one",
             width, height, volume.extent);

    // As far from the middle as the view allows, to a 4096th of its extent.
    double near_middle = 0, too_far = volume.extent;
    for (int halving = 0; halving < 12; ++halving) {
      const double shift = (near_middle + too_far) / 2;
      const bool seen = seen_whole(scanner, pose_number(i, volume, shift), width, height);
      (seen ? near_middle : too_far) = shift;
    }

    poses.push_back(pose_number(i, volume, near_middle));
  }

  return poses;
}

Body printed_sheet(const Image<std::uint8_t>& picture, double mm_per_pixel,
                   const Scanner& scanner) {
  constexpr double dark = 0.08, bright = 0.85;
  constexpr double blur = 0.5;  // camera pixels

  const double mm_of_camera_pixel =
      working_volume(scanner).centre.z() / scanner.camera.intrinsic(0, 0);
  return {
      .shape = Board{picture.width() * mm_per_pixel, picture.height() * mm_per_pixel},
      .texture = picture_texture(picture, mm_per_pixel, dark, bright, blur * mm_of_camera_pixel),
      .shading = Shading::lambertian};
}

Body misprinted(Body sheet, const Physics& physics) {
  // A stretched print has its points farther out along X.
  if (physics.board_stretch != 0) {
    const double share = 1 / (1 + physics.board_stretch);
    sheet.texture = [print = sheet.texture, share](const Eigen::Vector3d& p) {
      return print(Eigen::Vector3d(share * p.x(), p.y(), p.z()));
    };
  }

  // A parabola along X whose ends stay in place and whose middle bulges towards the camera.
  if (physics.board_bend != 0) {
    const Board flat = std::get<Board>(sheet.shape);
    Mesh mesh;
    append_surface(mesh, 1, 200, [&](double u, double v) {
      const double across = 2 * u - 1;
      return Eigen::Vector3d(across * flat.width / 2, (v - 0.5) * flat.height,
                             physics.board_bend * (across * across - 1));
    });
    sheet.shape = std::make_shared<const MeshTree>(mesh);
  }

  return sheet;
}

}  // namespace slipstream
