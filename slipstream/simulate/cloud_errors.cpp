#include "slipstream/simulate/cloud_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "slipstream/base/robust.h"
#include "slipstream/geometry/nearest_error.h"

namespace slipstream {
namespace {

/// The error at the pixel's own surface where it is no larger than noise may be: among neighbours
/// on a slope the nearest would flatter.
double depth_error(double z, double sigma, const Image<double>& depth, int column, int row) {
  const double own = z - depth(column, row);
  return std::abs(own) <= 5 * sigma ? own : nearest_error(z, depth, column, row);
}

/// Of a point from what rays within one and a half pixels of its own meet, mm.
double distance_to_surfaces(const Cloud& cloud, int column, int row, const Scanner& scanner,
                            const Scene& scene) {
  const Eigen::Vector3d point(cloud.x(column, row), cloud.y(column, row), cloud.z(column, row));
  double nearest = std::numeric_limits<double>::infinity();
  for (double y = row - 1.5; y <= row + 1.5; y += 0.25) {
    for (double x = column - 1.5; x <= column + 1.5; x += 0.25) {
      const Ray ray{Eigen::Vector3d::Zero(), ray_through(scanner.camera, {x, y})};
      const auto surface = first_surface(scene, ray, 0);
      if (surface) nearest = std::min(nearest, (surface->point - point).norm());
    }
  }
  return nearest;
}

}  // namespace

CloudErrors cloud_errors(const Cloud& cloud, const Uncertainty& uncertainty,
                         const Image<float>& coordinate, const Layout& layout,
                         const VirtualScan& truth, const Scanner& scanner, const Scene& scene) {
  const double periods = measuring_band(layout).periods;
  CloudErrors errors;
  std::size_t lit = 0, measured = 0, on_surface = 0, within_5 = 0, flying = 0, wrong = 0;
  double squares = 0, normalised_squares = 0;
  for (int row = 0; row < cloud.size().height; ++row) {
    for (int column = 0; column < cloud.size().width; ++column) {
      const double y = truth.coordinate(column, row);
      if (std::isfinite(y)) ++lit;
      if (cloud.validity(column, row) != Validity::valid) continue;
      ++errors.points;
      if (std::isfinite(y)) ++measured;
      if (std::abs(coordinate(column, row) - y) * periods >= 0.5) ++wrong;
      const double z = cloud.z(column, row), sigma = uncertainty.z(column, row);
      const double error = depth_error(z, sigma, truth.depth, column, row);
      if (std::abs(error) <= 5 * sigma) {
        ++within_5;
        normalised_squares += std::pow(error / sigma, 2);
      }
      const double limit = std::max(5 * sigma, 1.0);
      const double off = std::abs(error) <= limit
                             ? std::abs(error)
                             : distance_to_surfaces(cloud, column, row, scanner, scene);
      if (off > limit) {
        ++flying;
      } else {
        ++on_surface;
        squares += off * off;
      }
    }
  }
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
  };
  errors.completeness = share(measured, lit);
  errors.rms = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(on_surface, 1)));
  errors.normalised_rms =
      std::sqrt(normalised_squares / static_cast<double>(std::max<std::size_t>(within_5, 1)));
  errors.beyond_5 = share(errors.points - within_5, errors.points);
  errors.flying = share(flying, errors.points);
  errors.wrong_order = share(wrong, errors.points);
  return errors;
}

double repeatability(const Cloud& first, const Cloud& second) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < first.z.pixel_count(); ++i) {
    const double difference = std::abs(static_cast<double>(first.z.begin()[i]) -
                                       static_cast<double>(second.z.begin()[i]));
    if (std::isfinite(difference)) differences.push_back(difference);
  }
  if (differences.empty()) return 0;
  return deviation_from_median(median(std::move(differences))) / std::sqrt(2.0);
}

}  // namespace slipstream
