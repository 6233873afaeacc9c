#pragma once

#include <optional>
#include <span>
#include <vector>

#include "slipstream/base/size.h"
#include "slipstream/cloud/cloud.h"

namespace slipstream {

/// A point of a cloud, in the camera's frame, mm.
struct MeasuredPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  /// One standard deviation of each coordinate by the frames' noise, if known. Noise moves a point
  /// along the ray of its pixel, so the three err as one.
  std::optional<Eigen::Vector3d> sigma{};
};

/// The point of a pixel; none where the cloud has none or the pixel lies outside. `uncertainty`: of
/// the same cloud; null: not known.
std::optional<MeasuredPoint> point_at(const Cloud& cloud, const Uncertainty* uncertainty,
                                      int column, int row);

/// The points of the pixels in a rectangle, as far as it lies in the cloud.
std::vector<MeasuredPoint> points_in(const Cloud& cloud, const Uncertainty* uncertainty,
                                     const Rectangle& rectangle);

struct Distance {
  double length = 0;            ///< mm
  std::optional<double> sigma;  ///< mm, where both points have one, taken to be independent
};

Distance distance(const MeasuredPoint& from, const MeasuredPoint& to);

/// How far from a fitted shape the points lie that it was fitted to, mm.
struct Residuals {
  double rms = 0;
  double largest = 0;
  std::size_t points = 0;       ///< that it was fitted to
  std::size_t outliers = 0;     ///< farther than 4 robust standard deviations, left out
  std::optional<double> noise;  ///< rms by the frames' noise alone, where all have sigma
};

struct FittedPlane {
  Eigen::Vector3d normal = -Eigen::Vector3d::UnitZ();  ///< unit length, towards the camera
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    ///< mean of its points
  Residuals residuals;
};

struct FittedSphere {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0;
  double radius_sigma = 0;  ///< one standard deviation, by the residuals, taken to be independent
  Residuals residuals;
};

/// The shape of least squared distances from the points, without outliers, which may be up to a
/// third: of shapes through points drawn at random (always the same) the one of least median
/// distance tells them. Throws Error for fewer than 3 (plane) or 4 (sphere) points, or where they
/// do not make out one shape: on a line, or for a sphere on a plane.
/// With `left_out` the outliers are that share of the points, the farthest from the shape, as
/// acceptance tests ask for.
FittedPlane fit_plane(std::span<const MeasuredPoint> points, std::optional<double> left_out = {});
FittedSphere fit_sphere(std::span<const MeasuredPoint> points, std::optional<double> left_out = {});

/// The same with the radius of a sphere near it: where little of a sphere is seen, a known radius
/// makes its centre surer. Throws Error for fewer than 4 points.
FittedSphere fit_sphere_near(std::span<const MeasuredPoint> points, const FittedSphere& near);

/// How far a point lies from the shape, mm: positive towards the camera, or outside.
double signed_distance(const FittedPlane& plane, const Eigen::Vector3d& point);
double signed_distance(const FittedSphere& sphere, const Eigen::Vector3d& point);

/// One or two spheres of known size in an organised cloud: each is looked for where most points put
/// its centre, a radius below them along their normals, and fitted with a free radius. In the order
/// of `radii` (mm, above 0), or the other where that fits better. Throws Error where no sphere of
/// such a size, or too little of it, is seen.
std::vector<FittedSphere> find_spheres(const Cloud& cloud, std::span<const double> radii);

/// Whether the camera's ray through a point meets the sphere at most `widest_angle` (rad) from its
/// normal, however far from the sphere the point lies: errors there belong to the sphere's form.
bool is_on_cap(const FittedSphere& sphere, const Eigen::Vector3d& point, double widest_angle);

}  // namespace slipstream
