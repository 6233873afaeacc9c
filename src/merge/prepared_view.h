#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "merge/features.h"
#include "merge/point_grid.h"
#include "merge/seen_surface.h"
#include "merge/view.h"

namespace slipstream {

/// A view with what registration looks up in it again and again.
class PreparedView {
 public:
  /// `cell`: distance of the keypoints, mm; common to all views that are to be joined.
  PreparedView(View view, float cell);

  [[nodiscard]] const View& view() const { return view_; }
  [[nodiscard]] const PointGrid& grid() const { return grid_; }
  /// The surface at each point: where points are dense and noisy, the mean of those around it.
  /// Elsewhere, where the curvature between them would matter more than the noise, the point.
  [[nodiscard]] std::span<const Eigen::Vector3f> smooth_points() const {
    return smooth_points_.empty() ? view_.points : smooth_points_;
  }
  /// The standard deviations of the view's points, and of the smooth ones, along the normal, mm: by
  /// noise, and at creases by the distance between points.
  [[nodiscard]] std::span<const float> sigma() const { return sigma_; }
  [[nodiscard]] std::span<const float> smooth_sigma() const {
    return smooth_points_.empty() ? sigma_ : smooth_sigma_;
  }
  [[nodiscard]] const Keypoints& keypoints() const { return keypoints_; }
  [[nodiscard]] const PointGrid& keypoint_grid() const { return keypoint_grid_; }
  [[nodiscard]] const SeenSurface& seen() const { return seen_; }
  /// About 10,000 points, evenly over the surface.
  [[nodiscard]] const std::vector<std::uint32_t>& sample() const { return sample_; }
  /// Motions after which parts of the view look like others: those of symmetric and repeated
  /// shapes.
  [[nodiscard]] const std::vector<Eigen::Isometry3d>& symmetries() const { return symmetries_; }
  /// How much the surface leans against its least known motion: RMS slope, 0 for a plane or sphere.
  [[nodiscard]] double weakest_slope() const { return weakest_slope_; }
  [[nodiscard]] const Eigen::Vector3d& middle() const { return middle_; }
  [[nodiscard]] double reach() const { return reach_; }  ///< of the points from the middle, mm

 private:
  void smooth();
  void find_symmetries(std::vector<Eigen::Isometry3d> starts);

  View view_;
  PointGrid grid_;
  std::vector<Eigen::Vector3f> smooth_points_{};  ///< empty if no point needs the mean
  std::vector<float> smooth_sigma_{}, sigma_{};
  Keypoints keypoints_;
  PointGrid keypoint_grid_;
  SeenSurface seen_;
  std::vector<std::uint32_t> sample_;
  std::vector<Eigen::Isometry3d> symmetries_;
  double weakest_slope_ = 0;
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
  double reach_ = 0;
};

/// Edge of the patches whose errors count as independent, mm.
inline double patch_of(const PreparedView& view) {
  return 2 * view.keypoints().cell;
}

/// A distance of keypoints that suits the views: about 2500 of a middling view.
float keypoint_cell(const std::vector<View>& views);

}  // namespace slipstream
