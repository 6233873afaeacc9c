#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "geometry/point_fit.h"
#include "merge/prepared_view.h"

namespace slipstream {

/// A view's surface at one resolution; borrows it.
struct SurfaceSamples {
  std::span<const Eigen::Vector3f> points{}, normals{};
  std::span<const float> sigma{};  ///< empty: `level_sigma` for all
  /// Places that points of the other surface are compared with: PreparedView::smooth_points.
  std::span<const Eigen::Vector3f> smooth_points{};
  std::span<const float> smooth_sigma{};    ///< empty: `level_sigma` for all
  std::span<const std::uint32_t> sample{};  ///< indices of the points to compare; empty: all
  const PointGrid* grid = nullptr;
  float spacing = 0, level_sigma = 0;  ///< mm
};

SurfaceSamples coarse_surface(const PreparedView& view);
SurfaceSamples fine_surface(const PreparedView& view);

/// A point of the second surface and the first surface beside it, in the first view's frame.
struct SurfaceMatch {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< on the second surface
  Eigen::Vector3d first_normal = Eigen::Vector3d::Zero();
  Eigen::Vector3d second_normal = Eigen::Vector3d::Zero();
  double distance = 0;  ///< of the first surface from the place, along direction()
  double sigma = 0;     ///< standard deviation of the distance by the noise, mm

  [[nodiscard]] Eigen::Vector3d direction() const {
    return (first_normal + second_normal).normalized();
  }
};

/// The partner of a point on the other surface: at most `farthest` away, beside it by at most
/// about the spacing, and with a similar normal. nullopt without any.
std::optional<std::uint32_t> partner_of(const Eigen::Vector3f& place, const Eigen::Vector3f& normal,
                                        const SurfaceSamples& other, float farthest);

/// Partners of the samples of both surfaces, with the second at `pose`. Takes every `step`-th
/// sample.
std::vector<SurfaceMatch> match_surfaces(const SurfaceSamples& first, const SurfaceSamples& second,
                                         const Eigen::Isometry3d& pose, float farthest,
                                         std::size_t step = 1);

/// Normal equations of the distances for a small turn (rad) and shift (mm) of the second surface
/// about `centre`. Distances lose weight beyond the spread of most (Tukey's biweight).
struct SurfaceEquations {
  Matrix6 squares = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  /// As `squares`, with the normals of one surface times those of the other: their noise does not
  /// add to it, so that a plane has no information about motion along it.
  Matrix6 information = Matrix6::Zero();
  double weight = 0;  ///< sum over the matches
  double scale = 1;   ///< spread of the distances, in their standard deviations; at least 1
};

SurfaceEquations equations_of(const std::vector<SurfaceMatch>& matches,
                              const Eigen::Vector3d& centre);

/// Counts how many matches make one independent observation for a fit, by the scatter of the
/// residuals over patches of the views (a "sandwich" estimate): points near each other share
/// errors, and a point has matches to and fro, in several views.
class PatchScatter {
 public:
  /// `patch`: edge, mm.
  explicit PatchScatter(double patch) : patch_(patch) {}

  /// Adds the matches of views number `first` and `second`, the second at `pose`. `derivatives`: of
  /// the turn and shift about `centre` by each parameter.
  void add(std::size_t first, std::size_t second, const Eigen::Isometry3d& pose,
           const std::vector<SurfaceMatch>& matches, const Eigen::Vector3d& centre,
           const Eigen::Matrix<double, 6, Eigen::Dynamic>& derivatives);

  /// Matches for each independent observation, by which variances grow; at least 1.
  [[nodiscard]] double matches_each() const;

 private:
  using Patch = std::pair<std::size_t, std::uint64_t>;  ///< view, cell

  double patch_;
  /// Sums of weighted residuals times their derivatives.
  std::map<Patch, Eigen::VectorXd> sums_{};
  Eigen::MatrixXd counted_twice_{}, squares_{};
  double weights_ = 0, slopes_ = 0;  ///< of all matches, by Tukey's biweight
};

/// The least known motion: RMS slope of the surface against it, and its standard deviation, mm, at
/// `extent` from the centre.
struct WeakestMotion {
  double slope = 0, sigma = 0;
  Vector6 motion = Vector6::Zero();  ///< its turn (rad) and shift (mm) about the centre, any length
};

WeakestMotion weakest_motion(const SurfaceEquations& equations, double extent);

/// RMS distance of matches from their centre, mm.
double extent_of(const std::vector<SurfaceMatch>& matches, const Eigen::Vector3d& centre);

/// Mean place of matches.
Eigen::Vector3d centre_of(const std::vector<SurfaceMatch>& matches);

/// Moves the second surface to where its distances from the first are least, from `pose`; distances
/// up to `farthest` at first, `nearest` at last, count. Undetermined motion keeps the start.
Eigen::Isometry3d settled_pose(const SurfaceSamples& first, const SurfaceSamples& second,
                               Eigen::Isometry3d pose, float farthest, float nearest, int rounds,
                               std::size_t step = 1);

}  // namespace slipstream
