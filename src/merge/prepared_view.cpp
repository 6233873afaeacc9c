#include "merge/prepared_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/statistics.h"
#include "merge/consensus.h"
#include "merge/surface_fit.h"

namespace slipstream {
namespace {

/// Area of the surface, by the cells it fills, mm^2.
double area_of(const View& view) {
  const float cell = 8 * view.spacing;
  return static_cast<double>(thinned_to_cells(view.points, cell).size()) * cell * cell;
}

/// Places along a motion of the surface on itself: all around its axis, or to both sides. A part
/// with a ring or a row of equal shapes repeats itself there.
std::vector<Eigen::Isometry3d> slid_along(const Vector6& motion, const Eigen::Vector3d& centre,
                                          double extent, double cell) {
  constexpr int around = 24, to_each_side = 8;

  std::vector<Eigen::Isometry3d> places;
  const Eigen::Vector3d turn = motion.head<3>(), shift = motion.tail<3>();
  if (turn.norm() * extent > shift.norm() / 4) {
    // The axis of the turn passes where the motion has no shift across it.
    const Eigen::Vector3d axis = turn.normalized();
    const Eigen::Vector3d on_axis = centre + turn.cross(shift) / turn.squaredNorm();
    for (int k = 1; k < around; ++k) {
      const Eigen::AngleAxisd part(2 * std::numbers::pi * k / around, axis);
      places.push_back(Eigen::Translation3d(on_axis) * part * Eigen::Translation3d(-on_axis));
    }
    return places;
  }

  for (int k = -to_each_side; k <= to_each_side; ++k) {
    if (k != 0) places.emplace_back(Eigen::Translation3d(4 * cell * k * shift.normalized()));
  }
  return places;
}

}  // namespace

PreparedView::PreparedView(View view, float cell)
    : view_(std::move(view)),
      grid_(view_.points, 5 * view_.spacing),
      keypoints_(keypoints_of(view_, cell)),
      keypoint_grid_(keypoints_.points, 3 * cell),
      seen_(view_) {
  constexpr std::size_t sampled = 10'000;

  smooth();

  // Thinned by cells first, since near surface has more points than far surface.
  const double wanted = std::sqrt(area_of(view_) / static_cast<double>(sampled));
  const auto spacing = std::max(static_cast<float>(wanted), view_.spacing);
  sample_ = thinned_to_cells(view_.points, spacing);

  const auto count = static_cast<double>(view_.size());
  for (const Eigen::Vector3f& point : view_.points) middle_ += point.cast<double>() / count;
  double squares = 0;
  for (const Eigen::Vector3f& point : view_.points) {
    squares += (point.cast<double>() - middle_).squaredNorm() / count;
  }
  reach_ = std::sqrt(squares);

  // How the surface slides along itself, by normals with little noise: those of the keypoints.
  const SurfaceSamples coarse = coarse_surface(*this);
  const auto itself = match_surfaces(coarse, coarse, Eigen::Isometry3d::Identity(), cell / 10);
  const Eigen::Vector3d centre = centre_of(itself);
  const double extent = extent_of(itself, centre);
  const WeakestMotion weakest = weakest_motion(equations_of(itself, centre), extent);
  weakest_slope_ = weakest.slope;

  find_symmetries(slid_along(weakest.motion, centre, extent, cell));
}

void PreparedView::smooth() {
  constexpr float noisy = 0.2F, reach = 1.5F;  // spacings
  constexpr float by_bend = 0.25F;             // spacings for each rad
  const auto is_noisy = [&](float sigma) { return sigma >= noisy * view_.spacing; };

  sigma_ = view_.sigma;
  if (std::ranges::any_of(view_.sigma, is_noisy)) {
    smooth_points_ = view_.points;
    smooth_sigma_ = view_.sigma;
  }

  grid_.for_each_cell([&](std::span<const std::uint32_t> inside, const NearPoints& near) {
    for (const std::uint32_t i : inside) {
      Eigen::Vector3f place = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();  // sums
      float count = 0;
      near.for_each_near(view_.points[i], reach * view_.spacing,
                         [&](std::size_t k, const Eigen::Vector3f&) {
                           place += view_.points[near.indices[k]];
                           normal += view_.normals[near.indices[k]];
                           ++count;
                         });

      // At a crease the surface between the points is anywhere between its two sides.
      const float bend = std::sqrt(std::max(2 * (1 - normal.norm() / count), 0.F));
      const float between = by_bend * bend * view_.spacing;
      const float sigma = view_.sigma[i];
      sigma_[i] = std::hypot(sigma, between);
      if (smooth_points_.empty()) continue;

      smooth_sigma_[i] = std::hypot(is_noisy(sigma) ? sigma / std::sqrt(count) : sigma, between);
      if (is_noisy(sigma)) smooth_points_[i] = place / count;
    }
  });
}

void PreparedView::find_symmetries(std::vector<Eigen::Isometry3d> starts) {
  constexpr std::size_t most_alike = 1500, most_poses = 16, most_symmetries = 8;
  constexpr std::size_t step = 5;      // of the keypoints that are compared
  constexpr double least_share = 0.2;  // of the keypoints
  constexpr double distinct = 3;       // cells
  constexpr int rounds = 4;

  // Besides those along the least known motion, poses that similar features agree on; in order of
  // how much surface lies on other surface.
  const SurfaceSamples coarse = coarse_surface(*this);
  const auto alike = similar_keypoints(keypoints_, keypoints_, most_alike);
  for (const ConsensusPose& found : consensus_poses(keypoints_, keypoints_, alike, most_poses)) {
    starts.push_back(found.pose);
  }

  std::vector<std::pair<std::size_t, Eigen::Isometry3d>> found;
  for (const Eigen::Isometry3d& start : starts) {
    const float cell = keypoints_.cell;
    const Eigen::Isometry3d pose =
        settled_pose(coarse, coarse, start, 2 * cell, cell, rounds, step);
    const bool known = std::any_of(found.begin(), found.end(), [&](const auto& other) {
      return largest_displacement(pose, other.second, middle_, reach_) < distinct * cell;
    });
    const bool still = largest_displacement(pose, Eigen::Isometry3d::Identity(), middle_, reach_) <
                       distinct * cell;
    const std::size_t matches = match_surfaces(coarse, coarse, pose, cell / 2, step).size();
    const double share =
        static_cast<double>(step * matches) / (2.0 * static_cast<double>(keypoints_.points.size()));
    if (!known && !still && share > least_share) found.emplace_back(matches, pose);
  }

  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  for (const auto& [matches, pose] : found) {
    if (symmetries_.size() < most_symmetries) symmetries_.push_back(pose);
  }
}

float keypoint_cell(const std::vector<View>& views) {
  constexpr double keypoints = 2500;
  constexpr float finest = 3;  // spacings

  std::vector<double> cells;
  float spacing = 0;
  for (const View& view : views) {
    cells.push_back(std::sqrt(area_of(view) / keypoints));
    spacing = std::max(spacing, view.spacing);
  }
  return std::max(static_cast<float>(median(std::move(cells))), finest * spacing);
}

}  // namespace slipstream
