#include "slipstream/calibrate/board_quality.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace slipstream {
namespace {

/// RMS distance from the best plane.
double flatness_of(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) centre += point / static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& point : points) {
    scatter += (point - centre) * (point - centre).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[0]) / static_cast<double>(points.size()));
}

/// Sets what the distances between all pairs of points say.
void measure_distances(const std::vector<Eigen::Vector3d>& points,
                       const std::vector<Eigen::Vector3d>& printed, BoardQuality& quality) {
  double ratios = 0, squares = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double ought = (printed[i] - printed[j]).norm();
      const double error = (points[i] - points[j]).norm() - ought;
      ratios += error / ought;
      squares += error * error;
    }
  }
  const double pairs = static_cast<double>(points.size() * (points.size() - 1)) / 2;
  quality.scale_error = ratios / pairs;
  quality.distance_error = std::sqrt(squares / pairs);
}

}  // namespace

Eigen::Vector3d point_between(const Scanner& scanner, const Eigen::Vector2d& camera,
                              const Eigen::Vector2d& projector) {
  const Eigen::Vector3d u = ray_through(scanner.camera, camera).normalized();
  const Eigen::Vector3d v =
      (scanner.rotation.transpose() * ray_through(scanner.projector, projector)).normalized();
  const Eigen::Matrix3d across_u = Eigen::Matrix3d::Identity() - u * u.transpose();
  const Eigen::Matrix3d across_v = Eigen::Matrix3d::Identity() - v * v.transpose();
  return (across_u + across_v).inverse() * (across_v * projector_centre(scanner));
}

std::optional<BoardQuality> board_quality(const BoardView& view, const Scanner& scanner,
                                          const std::vector<Eigen::Vector3d>& printed) {
  std::vector<Eigen::Vector3d> points, places;
  for (std::size_t i = 0; i < view.places.size(); ++i) {
    if (!view.projector[i].allFinite()) continue;
    const Eigen::Vector3d point = point_between(scanner, view.camera[i], view.projector[i]);
    if (!point.allFinite()) continue;
    points.push_back(point);
    places.push_back(printed[static_cast<std::size_t>(view.places[i])]);
  }
  constexpr std::size_t fewest = 4;
  if (points.size() < fewest) return std::nullopt;
  BoardQuality quality{.flatness = flatness_of(points)};
  measure_distances(points, places, quality);
  return quality;
}

}  // namespace slipstream
