#include "calibrate/point_boards.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "calibrate/board_view.h"

namespace slipstream {
namespace {

using DevicePixels = std::vector<Eigen::Vector2d> PosePoints::*;

/// Whether all pixels are in a picture of that size, or just beside it.
bool all_fit(const std::vector<PosePoints>& poses, DevicePixels device, Size size) {
  const double margin = 0.02 * std::max(size.width, size.height);
  for (const PosePoints& pose : poses) {
    for (const Eigen::Vector2d& pixel : pose.*device) {
      const bool outside = pixel.minCoeff() < -margin || pixel.x() > size.width + margin ||
                           pixel.y() > size.height + margin;
      if (pixel.allFinite() && outside) return false;
    }
  }
  return true;
}

/// Rows become columns.
Size turned(Size size) {
  return {size.height, size.width};
}

void exchange_axes(std::vector<PosePoints>& poses, DevicePixels device) {
  for (PosePoints& pose : poses) {
    for (Eigen::Vector2d& pixel : pose.*device) std::swap(pixel.x(), pixel.y());
  }
}

/// Exchanges rows and columns if only that brings the pixels into the picture. Throws Error if
/// neither does.
void bring_into_picture(std::vector<PosePoints>& poses, DevicePixels device, Size size,
                        const std::string& name, std::vector<std::string>& notes) {
  if (all_fit(poses, device, size)) return;
  throw_if(!all_fit(poses, device, turned(size)),
           "points of the {} lie outside its picture of {}x{} pixels; check its size, and which "
           "columns are its pixels",
           name, size.width, size.height);

  exchange_axes(poses, device);
  notes.push_back(
      fmt::format("the {}'s pixels are row, column: only so do they lie in its picture", name));
}

/// The A of the best fit over the points of a pose: projector pixel = A camera pixel + b. nullopt
/// for too few.
std::optional<Eigen::Matrix2d> from_camera_to_projector(const PosePoints& pose) {
  std::vector<std::size_t> both;
  for (std::size_t i = 0; i < pose.camera.size(); ++i) {
    if (pose.camera[i].allFinite() && pose.projector[i].allFinite()) both.push_back(i);
  }
  if (both.size() < 4) return std::nullopt;

  Eigen::MatrixX3d from(both.size(), 3);
  Eigen::MatrixX2d to(both.size(), 2);
  for (std::size_t k = 0; k < both.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    from.row(row) << pose.camera[both[k]].transpose(), 1;
    to.row(row) = pose.projector[both[k]].transpose();
  }

  const Eigen::Matrix<double, 3, 2> solution = least_squares(from, to).X;
  return solution.topRows<2>().transpose();
}

/// Exchanges rows and columns of the device that must have them exchanged. Throws Error if the
/// devices mirror each other otherwise: they see the same side of a board.
void mend_mirrored(std::vector<PosePoints>& poses, Size camera, Size projector,
                   std::vector<std::string>& notes) {
  int mirrored = 0, exchanged = 0, count = 0;
  for (const PosePoints& pose : poses) {
    const auto A = from_camera_to_projector(pose);
    if (!A) continue;
    ++count;
    if (A->determinant() >= 0) continue;
    ++mirrored;

    // Exchanged axes have the larger elements off the diagonal.
    constexpr double clearly = 0.25;
    if (A->diagonal().squaredNorm() < clearly * A->squaredNorm()) ++exchanged;
  }
  if (2 * mirrored <= count) return;

  const bool may_turn_camera = all_fit(poses, &PosePoints::camera, turned(camera));
  const bool may_turn_projector = all_fit(poses, &PosePoints::projector, turned(projector));
  throw_if(4 * exchanged < 3 * mirrored,
           "camera and projector mirror each other, though both see the same side of the board: a "
           "picture is mirrored, or an axis of its pixels points the other way");
  throw_if(may_turn_camera == may_turn_projector,
           "rows and columns are exchanged in the pixels of camera or projector, and the points do "
           "not say in which; give `swap camera` or `swap projector`");

  exchange_axes(poses, may_turn_camera ? &PosePoints::camera : &PosePoints::projector);
  notes.push_back(fmt::format(
      "the {}'s pixels are row, column: else camera and projector would mirror each other",
      may_turn_camera ? "camera" : "projector"));
}

/// Largest side of the box around all points of the boards, in their unit.
double extent_of(const std::vector<PosePoints>& poses) {
  double extent = 0;
  for (const PosePoints& pose : poses) {
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& point : pose.board) box.extend(point);
    if (!box.isEmpty()) extent = std::max(extent, box.sizes().maxCoeff());
  }
  return extent;
}

/// Median distance of a pose's points to the next, from about a thousand of them.
double spacing_of(const PosePoints& pose) {
  constexpr std::size_t most_looked_at = 1000;

  std::vector<double> distances;
  const std::size_t step = pose.board.size() / most_looked_at + 1;
  for (std::size_t i = 0; i < pose.board.size(); i += step) {
    const Eigen::Vector3d& point = pose.board[i];
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& other : pose.board) {
      const double distance = (other - point).norm();
      if (distance > 0) nearest = std::min(nearest, distance);
    }
    distances.push_back(nearest);
  }
  return median(std::move(distances));
}

/// Scales the boards to mm.
void scale_to_mm(std::vector<PosePoints>& poses, const PointConventions& conventions,
                 std::vector<std::string>& notes) {
  const double extent = extent_of(poses);
  throw_if(!(extent > 0) || !std::isfinite(extent),
           "the board's points have no extent; check which columns are the board's");

  constexpr double smallest_board = 2;  // mm
  constexpr double mm_per_metre = 1000;
  double unit = conventions.unit.value_or(1);
  if (!conventions.unit && extent < smallest_board) {
    unit = mm_per_metre;
    notes.push_back(fmt::format("the board's points are in metres: they span {:.3g}", extent));
  } else if (!conventions.unit && std::abs(spacing_of(poses.front()) - 1) < 1e-6) {
    notes.emplace_back(
        "the board's points are 1 mm apart; if they count squares or circles, give the distance "
        "between these in mm as `unit`");
  }

  for (PosePoints& pose : poses) {
    for (Eigen::Vector3d& point : pose.board) point *= unit;
  }
}

/// Turns the points of a pose so that they are on Z = 0, if they are not yet in a plane of one z.
/// Throws Error if they are not flat.
void lay_flat(PosePoints& pose) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& point : pose.board) centre += point / static_cast<double>(pose.board.size());

  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& point : pose.board) scatter += (point - centre) * (point - centre).transpose();

  const PrincipalAxes axes = principal_axes(scatter);
  constexpr double most = 0.02;  // of the board's size: measured boards are not quite flat
  throw_if(!(axes.values[0] <= most * most * axes.values[2]), "{}: the board's points are not flat",
           pose.name);
  throw_if(!(axes.values[1] > most * most * axes.values[2]), "{}: the board's points are on a line",
           pose.name);

  // Points in a plane of one z keep x and y, so that they are the same places in all poses.
  const Eigen::Vector3d normal = axes.vectors.col(0);
  constexpr double level = 0.9999;
  const bool is_level = std::abs(normal.z()) > level;
  const auto turn = Eigen::Quaterniond::FromTwoVectors(normal, Eigen::Vector3d::UnitZ());

  for (Eigen::Vector3d& point : pose.board) {
    if (!is_level) point = turn * (point - centre);
    if (is_level) point.z() -= centre.z();
  }
}

/// Numbers the points of all poses: equal coordinates are one place.
class Places {
 public:
  explicit Places(double extent) : step_(1e-6 * extent) {}

  int number_of(const Eigen::Vector3d& point) {
    std::array<long, 3> key{};
    for (int axis = 0; axis < 3; ++axis) key.at(axis) = std::lround(point[axis] / step_);

    const auto [found, is_new] = numbers_.emplace(key, static_cast<int>(places_.size()));
    if (is_new) places_.push_back(point);
    return found->second;
  }

  [[nodiscard]] const BoardPlaces& places() const { return places_; }

 private:
  double step_;
  std::map<std::array<long, 3>, int> numbers_;
  BoardPlaces places_;
};

}  // namespace

PointBoards boards_of_points(std::vector<PosePoints> poses, Size camera, Size projector,
                             const PointConventions& conventions) {
  throw_if(poses.empty(), "no poses of the board");
  PointBoards boards;

  // 1. Pixels: column, row, from 0.
  for (PosePoints& pose : poses) {
    for (auto* pixels : {&pose.camera, &pose.projector}) {
      for (Eigen::Vector2d& pixel : *pixels) pixel.array() -= conventions.first_pixel;
    }
  }
  if (conventions.swaps_camera) exchange_axes(poses, &PosePoints::camera);
  if (conventions.swaps_projector) exchange_axes(poses, &PosePoints::projector);

  bring_into_picture(poses, &PosePoints::camera, camera, "camera", boards.notes);
  bring_into_picture(poses, &PosePoints::projector, projector, "projector", boards.notes);
  mend_mirrored(poses, camera, projector, boards.notes);

  // 2. Boards in mm, flat.
  scale_to_mm(poses, conventions, boards.notes);
  for (PosePoints& pose : poses) lay_flat(pose);
  boards.spacing = spacing_of(poses.front());

  // 3. Views of the places.
  Places places(extent_of(poses));
  constexpr int fewest = 4;
  for (const PosePoints& pose : poses) {
    BoardView view{
        .name = pose.name, .places = {}, .camera = pose.camera, .projector = pose.projector};
    for (const Eigen::Vector3d& point : pose.board) view.places.push_back(places.number_of(point));

    if (lit_corners(view) < fewest) {
      boards.unused.push_back({pose.name, "fewer than 4 points have both pixels"});
    } else {
      boards.views.push_back(std::move(view));
    }
  }

  boards.places = places.places();
  return boards;
}

}  // namespace slipstream
