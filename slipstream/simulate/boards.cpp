#include "slipstream/simulate/boards.h"

#include <cmath>
#include <iterator>
#include <memory>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/simulate/named_scenes.h"
#include "slipstream/simulate/virtual_camera.h"

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

/// Share of the way from one pose to another.
Eigen::Isometry3d between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                          double share) {
  const Eigen::Quaterniond turn(from.linear()), end(to.linear());
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate((1 - share) * from.translation() + share * to.translation());
  pose.rotate(turn.slerp(share, end));
  return pose;
}

/// Each pattern alone, in the order in which they are shown.
std::vector<PatternSet> cycle_of(const std::vector<PatternSet>& sets) {
  std::vector<PatternSet> cycle;
  for (const PatternSet& set : sets) {
    for (int n = 0; n < set.count; ++n) cycle.push_back(pattern_alone(set, n));
  }
  return cycle;
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

Reel moved_board(const VirtualWorld& world, Body sheet, const std::vector<Eigen::Isometry3d>& poses,
                 const std::vector<PatternSet>& sets, int still_cycles,
                 const std::function<void()>& rendered) {
  if (poses.empty() || sets.empty() || still_cycles < 1) {
    throw Error("a board that is moved needs a pose, a set of patterns and a cycle at least");
  }
  const std::vector<PatternSet> cycle = cycle_of(sets);
  Photometry photometry = world.photometry;
  photometry.rays = 1;  // what is printed on a sheet has soft edges of its own
  Reel reel;
  const auto expose = [&](const PatternSet& patterns) {
    std::vector<Frame> seen = virtual_frames(world.scanner, {sheet}, patterns, photometry, 1);
    photometry.seed += seen.size();
    reel.frames.insert(reel.frames.end(), std::make_move_iterator(seen.begin()),
                       std::make_move_iterator(seen.end()));
  };
  for (std::size_t p = 0; p < poses.size(); ++p) {
    const std::size_t first = reel.frames.size();
    reel.enough = reel.order.size() + cycle.size();  // who takes a pose sees a cycle of it
    sheet.pose = poses[p];
    for (const PatternSet& set : sets) expose(set);
    for (std::size_t k = 0; k < cycle.size() * static_cast<std::size_t>(still_cycles); ++k) {
      reel.order.push_back(first + k % cycle.size());
    }
    for (std::size_t k = 0; k < cycle.size(); ++k) {
      const double share = static_cast<double>(k + 1) / static_cast<double>(cycle.size() + 1);
      sheet.pose = between(poses[p], poses[(p + 1) % poses.size()], share);
      reel.order.push_back(reel.frames.size());
      expose(cycle[k]);
    }
    rendered();
  }
  return reel;
}

}  // namespace slipstream
