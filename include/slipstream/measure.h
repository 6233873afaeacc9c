#pragma once

#include <optional>
#include <span>
#include <vector>

#include "slipstream/cloud.h"

namespace slipstream {

/// A point of a cloud, in the camera's frame, mm.
struct MeasuredPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  /// One standard deviation of each coordinate due to the frames' noise, if known. Noise moves a
  /// point along its ray, so the three errors are fully correlated.
  std::optional<Eigen::Vector3d> sigma{};
};

/// The point of a pixel; nullopt if the pixel is invalid or outside the cloud. `uncertainty`: of
/// the same cloud; null: unknown.
std::optional<MeasuredPoint> point_at(const Cloud& cloud, const Uncertainty* uncertainty,
                                      int column, int row);

/// The points of the pixels in a rectangle, clipped to the cloud; of all pixels without one.
std::vector<MeasuredPoint> points_in(const Cloud& cloud, const Uncertainty* uncertainty = nullptr,
                                     std::optional<Rectangle> rectangle = std::nullopt);

struct Distance {
  double length = 0;              ///< mm
  std::optional<double> sigma{};  ///< mm, if both points have one, assumed independent
};

Distance distance(const MeasuredPoint& from, const MeasuredPoint& to);

/// Distances of points from the shape fitted to them, mm.
struct Residuals {
  double rms = 0;
  double largest = 0;
  std::size_t points = 0;         ///< used in the fit
  std::size_t outliers = 0;       ///< farther than 4 robust standard deviations, excluded
  std::optional<double> noise{};  ///< rms expected from the frames' noise alone, if all have sigma
};

struct FittedPlane {
  Eigen::Vector3d normal = -Eigen::Vector3d::UnitZ();  ///< unit length, towards the camera
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    ///< mean of its points
  Residuals residuals{};
};

struct FittedSphere {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0;
  double radius_sigma = 0;  ///< one standard deviation, from the residuals, assumed independent
  Residuals residuals{};
};

/// Least-squares fit without outliers, which may be up to a third of the points. Outliers are
/// identified by the shape of least median distance among shapes through random points (the same in
/// each run). With `left_out`, excludes this share of the points farthest from the shape, as
/// required by acceptance tests. Throws Error for fewer than 3 (plane) or 4 (sphere) points, or if
/// they do not determine the shape: on a line, or on a plane for a sphere.
FittedPlane fit_plane(std::span<const MeasuredPoint> points, std::optional<double> left_out = {});
FittedSphere fit_sphere(std::span<const MeasuredPoint> points, std::optional<double> left_out = {});

/// The same with the fixed radius of `near`: if little of a sphere is visible, a known radius makes
/// its centre more accurate. Throws Error for fewer than 4 points.
FittedSphere fit_sphere_near(std::span<const MeasuredPoint> points, const FittedSphere& near);

/// Distance of a point from the shape, mm: positive towards the camera, or outside.
double signed_distance(const FittedPlane& plane, const Eigen::Vector3d& point);
double signed_distance(const FittedSphere& sphere, const Eigen::Vector3d& point);

/// Finds one or two spheres of known size in an organised cloud. Each point votes for a centre, one
/// radius below it along its normal; the sphere is then fitted with a free radius. Returns them in
/// the order of `radii` (mm, above 0), or reversed if that fits better. Throws Error if no sphere
/// of such a size is visible, or too little of it.
std::vector<FittedSphere> find_spheres(const Cloud& cloud, std::span<const double> radii);

/// Whether the camera's ray through a point meets the sphere at most `widest_angle` (rad) from its
/// normal, at any distance of the point: errors there are form errors of the sphere.
bool is_on_cap(const FittedSphere& sphere, const Eigen::Vector3d& point, double widest_angle);

}  // namespace slipstream
