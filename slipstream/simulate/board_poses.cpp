#include "slipstream/simulate/board_poses.h"

#include <cmath>
#include <memory>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/simulate/named_scenes.h"

namespace slipstream {
namespace {

bool in_picture(const Lens& lens, const Eigen::Vector3d& point) {
  constexpr double margin = 0.01;  // of the picture
  if (point.z() <= 0) return false;
  const Eigen::Vector2d pixel = project(lens, point);
  const auto inside = [](double position, int length) {
    return position > margin * length && position < (1 - margin) * length;
  };
  return inside(pixel.x(), lens.size.width) && inside(pixel.y(), lens.size.height);
}

bool seen_whole(const Scanner& scanner, const Eigen::Isometry3d& pose, double width,
                double height) {
  for (const double x : {-0.5, 0.0, 0.5}) {
    for (const double y : {-0.5, 0.0, 0.5}) {
      const Eigen::Vector3d point = pose * Eigen::Vector3d(x * width, y * height, 0);
      if (!in_picture(scanner.camera, point)) return false;
      if (!in_picture(scanner.projector, in_projector_frame(scanner, point))) return false;
    }
  }
  return true;
}

/// Pose `i`, moved from the middle by `shift` in its own direction.
Eigen::Isometry3d pose_number(int i, const WorkingVolume& volume, double shift) {
  constexpr double golden_angle = 2.399963;  // rad: no two poses lean or move the same way
  const double lean_direction = golden_angle * i;
  const double lean = (15 + 20 * std::fmod(0.618 * i, 1.0)) * degree;
  const double nearness = 1 + 0.12 * std::cos(2.1 * i);
  const double spin = 12 * degree * std::sin(1.3 * i);
  const double move_direction = golden_angle * i * 2 + 0.7;

  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(volume.centre * nearness +
                 shift * Eigen::Vector3d(std::cos(move_direction), std::sin(move_direction), 0));
  pose.rotate(Eigen::AngleAxisd(
      lean, Eigen::Vector3d(std::cos(lean_direction), std::sin(lean_direction), 0)));
  pose.rotate(Eigen::AngleAxisd(spin, Eigen::Vector3d::UnitZ()));
  return pose;
}

}  // namespace

std::vector<Eigen::Isometry3d> board_poses(const Scanner& scanner, int count, double width,
                                           double height) {
  const WorkingVolume volume = working_volume(scanner);
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < count; ++i) {
    if (!seen_whole(scanner, pose_number(i, volume, 0), width, height)) {
      throw Error(
          fmt::format("a board of {:.4g}x{:.4g} mm does not fit into the scanner's view, "
                      "which is about {:.4g} mm; a smaller one is wanted",
                      width, height, volume.extent));
    }
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
  if (physics.board_stretch != 0) {
    const double share = 1 / (1 + physics.board_stretch);
    sheet.texture = [print = sheet.texture, share](const Eigen::Vector3d& p) {
      return print(Eigen::Vector3d(share * p.x(), p.y(), p.z()));
    };
  }
  if (physics.board_bend != 0) {
    const Board flat = std::get<Board>(sheet.shape);
    Mesh mesh;
    append_surface(mesh, 1, 200, [&](double u, double v) {
      const double across = 2 * u - 1;
      return Eigen::Vector3d(across * flat.width / 2, (v - 0.5) * flat.height,
                             physics.board_bend * (across * across - 1));
    });
    sheet.shape = std::make_shared<const MeshTree>(std::move(mesh));
  }
  return sheet;
}

}  // namespace slipstream
