#include "calibrate/reprojection.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include <Eigen/LU>

#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "calibrate/board_view.h"

namespace slipstream {
namespace {

/// Standard deviation of the components, from the median of their magnitudes.
double robust_deviation(std::vector<double> sizes) {
  if (sizes.empty()) return 1;
  constexpr double least = 1e-3;  // pixels: limits the weight of noise-free pictures
  return std::max(deviation_from_median(median(std::move(sizes))), least);
}

/// Calls `use` for each corner of all views with the residuals of camera and projector, and the
/// projector's residual without the part that the camera's causes.
template <class Use>
void for_each_corner(const BoardViews& views, const BundleState& state, const Use& use) {
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto camera = residuals(views[v], state, v, Device::camera);
    const auto projector = residuals(views[v], state, v, Device::projector);
    for (std::size_t i = 0; i < camera.size(); ++i) {
      Eigen::Vector2d own = projector[i];
      if (camera[i].allFinite()) own -= slope_at(views[v], i) * camera[i];
      use(camera[i], projector[i], own);
    }
  }
}

Squares squares_of(const PixelPlaces& residuals) {
  Squares squares;
  for (const Eigen::Vector2d& residual : residuals) {
    if (residual.allFinite()) squares.add(residual.squaredNorm());
  }
  return squares;
}

/// The point nearest to the rays through a camera and a projector pixel, camera frame, mm.
Eigen::Vector3d point_between(const Scanner& scanner, const Eigen::Vector2d& camera,
                              const Eigen::Vector2d& projector) {
  // Rays from the camera's and the projector's centre, in the camera frame.
  const Eigen::Vector3d u = ray_through(scanner.camera, camera).normalized();
  const Eigen::Vector3d v =
      (scanner.rotation.transpose() * ray_through(scanner.projector, projector)).normalized();

  // Least squares of the distances: each matrix removes the part along its ray.
  const Eigen::Matrix3d across_u = Eigen::Matrix3d::Identity() - u * u.transpose();
  const Eigen::Matrix3d across_v = Eigen::Matrix3d::Identity() - v * v.transpose();
  return (across_u + across_v).inverse() * (across_v * projector_centre(scanner));
}

/// RMS distance from the best plane.
double flatness_of(const BoardPlaces& points) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) centre += point / static_cast<double>(points.size());

  // The scatter's smallest eigenvalue is the sum of squared distances from the best plane.
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& point : points) {
    scatter += (point - centre) * (point - centre).transpose();
  }

  const double least = principal_axes(scatter).values[0];
  return std::sqrt(std::max(0.0, least) / static_cast<double>(points.size()));
}

/// Sets the results from the distances between all pairs of points.
void measure_distances(const BoardPlaces& points, const BoardPlaces& printed,
                       BoardQuality& quality) {
  double ratios = 0;
  Squares errors;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double ought = (printed[i] - printed[j]).norm();
      const double error = (points[i] - points[j]).norm() - ought;
      ratios += error / ought;
      errors.add(error * error);
    }
  }

  quality.scale_error = ratios / errors.count;
  quality.distance_error = errors.rms();
}

}  // namespace

PixelPlaces residuals(const BoardView& view, const BundleState& state, std::size_t v,
                      Device device) {
  const Scanner& scanner = state.scanner;
  PixelPlaces result;
  for (std::size_t i = 0; i < view.places.size(); ++i) {
    const Eigen::Vector3d point = state.poses[v] * state.places[view.places[i]];
    result.emplace_back(device == Device::camera
                            ? view.camera[i] - project(scanner.camera, point)
                            : view.projector[i] -
                                  project(scanner.projector, in_projector_frame(scanner, point)));
  }

  return result;
}

SomePoses some_poses(const BoardViews& views, const BundleState& state,
                     const std::function<bool(std::size_t)>& takes) {
  SomePoses some{{}, {state.scanner, {}, state.places}};
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!takes(v)) continue;
    some.views.push_back(views[v]);
    some.state.poses.push_back(state.poses[v]);
  }

  return some;
}

PixelDeviations pixel_deviations(const BoardViews& views, const BundleState& state) {
  std::vector<double> camera, projector;

  const auto collect = [](const Eigen::Vector2d& residual, std::vector<double>& sizes) {
    if (!residual.allFinite()) return;
    sizes.push_back(std::abs(residual.x()));
    sizes.push_back(std::abs(residual.y()));
  };

  for_each_corner(views, state, [&](const auto& of_camera, const auto&, const auto& own) {
    collect(of_camera, camera);
    collect(own, projector);
  });

  return {robust_deviation(std::move(camera)), robust_deviation(std::move(projector))};
}

double mean_squared_error(const BoardViews& views, const BundleState& state,
                          const PixelDeviations& deviations) {
  Squares squares;
  for_each_corner(views, state,
                  [&](const auto& of_camera, const auto& of_projector, const auto& own) {
                    if (!of_camera.allFinite() || !of_projector.allFinite()) return;
                    squares.add((of_camera / deviations.camera).squaredNorm() +
                                (own / deviations.projector).squaredNorm());
                  });
  return squares.count > 0 ? squares.sum / squares.count : 0;
}

ReprojectionRms Reprojection::rms() const {
  Squares both = camera;
  both.add(projector);
  return {camera.rms(), projector.rms(), both.rms()};
}

Reprojection reprojection(const BoardView& view, const BundleState& state, std::size_t v) {
  return {squares_of(residuals(view, state, v, Device::camera)),
          squares_of(residuals(view, state, v, Device::projector))};
}

Reprojection reprojection(const BoardViews& views, const BundleState& state) {
  Reprojection all;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Reprojection of_pose = reprojection(views[v], state, v);
    all.camera.add(of_pose.camera);
    all.projector.add(of_pose.projector);
  }
  return all;
}

std::optional<BoardQuality> board_quality(const BoardView& view, const Scanner& scanner,
                                          const BoardPlaces& printed) {
  BoardPlaces points, places;
  for (std::size_t i = 0; i < view.places.size(); ++i) {
    if (!view.projector[i].allFinite()) continue;

    const Eigen::Vector3d point = point_between(scanner, view.camera[i], view.projector[i]);
    if (!point.allFinite()) continue;

    points.push_back(point);
    places.push_back(printed[view.places[i]]);
  }

  constexpr std::size_t fewest = 4;
  if (points.size() < fewest) return std::nullopt;

  BoardQuality quality{.flatness = flatness_of(points)};
  measure_distances(points, places, quality);
  return quality;
}

}  // namespace slipstream
