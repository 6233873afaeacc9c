#include "slipstream/cloud/spheres.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "slipstream/cloud/depth_step.h"
#include "slipstream/cloud/normals.h"
#include "slipstream/error/error.h"

namespace slipstream {
namespace {

using Vector = Eigen::Vector3d;

constexpr std::size_t least_points = 100;

/// A point of the cloud and its surface's normal, towards the camera.
struct SurfaceElement {
  Vector point, normal;
};

std::vector<SurfaceElement> surface_elements(const Cloud& cloud) {
  const Normals normals = smoothed_normals(cloud);
  std::vector<SurfaceElement> elements;
  for (int row = 0; row < cloud.size().height; ++row) {
    for (int column = 0; column < cloud.size().width; ++column) {
      const Vector normal(normals.x(column, row), normals.y(column, row), normals.z(column, row));
      if (normal.allFinite()) elements.push_back({position_at(cloud, column, row), normal});
    }
  }
  return elements;
}

/// The cell of a grid that most places lie in: its middle. Places farther than 2^20 cells count for
/// nothing.
std::optional<Vector> fullest_cell(const std::vector<Vector>& places, double cell) {
  using Cell = std::array<int, 3>;
  constexpr double farthest = 1 << 20;
  std::vector<Cell> cells;
  for (const Vector& place : places) {
    const Vector scaled = (place / cell).array().floor();
    if (scaled.cwiseAbs().maxCoeff() > farthest) continue;
    cells.push_back(
        {static_cast<int>(scaled.x()), static_cast<int>(scaled.y()), static_cast<int>(scaled.z())});
  }
  std::sort(cells.begin(), cells.end());
  std::optional<Vector> fullest;
  std::ptrdiff_t most = 0;
  for (auto first = cells.begin(); first != cells.end();) {
    const auto end = std::upper_bound(first, cells.end(), *first);
    if (end - first > most) {
      most = end - first;
      fullest = cell * (Vector((*first)[0], (*first)[1], (*first)[2]) + Vector::Constant(0.5));
    }
    first = end;
  }
  return fullest;
}

/// Where an element says that the centre of a sphere of that radius is.
Vector vote_of(const SurfaceElement& element, double radius) {
  return element.point - radius * element.normal;
}

/// Where most elements say it is: the mean of their votes about the fullest cell, which moves until
/// it stays.
std::optional<Vector> centre_by_votes(const std::vector<SurfaceElement>& elements, double radius,
                                      double reach) {
  constexpr int rounds = 10;
  std::vector<Vector> votes;
  for (const SurfaceElement& element : elements) votes.push_back(vote_of(element, radius));
  std::optional<Vector> centre = fullest_cell(votes, reach);
  for (int round = 0; centre && round < rounds; ++round) {
    Vector sum = Vector::Zero();
    int count = 0;
    for (const Vector& vote : votes) {
      if ((vote - *centre).norm() > reach) continue;
      sum += vote;
      ++count;
    }
    if (count < static_cast<int>(least_points)) return std::nullopt;
    centre = sum / count;
  }
  return centre;
}

std::optional<FittedSphere> sphere_at(const Cloud& cloud, const Vector& centre, double radius) {
  constexpr double sure_angle = 60 * std::numbers::pi / 180;
  FittedSphere rough{.centre = centre, .radius = radius, .residuals = {}};
  std::vector<MeasuredPoint> points = points_on(cloud, rough, sure_angle);
  const std::size_t seen = points.size();
  std::erase_if(points, [&](const MeasuredPoint& point) {
    return std::abs(signed_distance(rough, point.position)) > radius / 4;
  });
  if (points.size() < least_points || points.size() < seen / 2) return std::nullopt;
  try {
    const FittedSphere sphere = fit_sphere(points);
    if (std::abs(sphere.radius - radius) < radius / 10) return sphere;
  } catch (const Error&) {  // they make out no sphere at all
  }
  return std::nullopt;
}

/// What looks most like it and is one: each place where none is frees the view to the next.
std::optional<FittedSphere> find_sphere(const Cloud& cloud, std::vector<SurfaceElement> elements,
                                        double radius) {
  constexpr int most_places = 20;
  const double reach = radius / 3;
  for (int place = 0; place < most_places; ++place) {
    const std::optional<Vector> centre = centre_by_votes(elements, radius, reach);
    if (!centre) return std::nullopt;
    if (const auto sphere = sphere_at(cloud, *centre, radius)) return sphere;
    std::erase_if(elements, [&](const SurfaceElement& element) {
      return (vote_of(element, radius) - *centre).norm() <= reach;
    });
  }
  return std::nullopt;
}

/// How much the spheres' radii differ from the others, mm.
double misfit(const std::vector<FittedSphere>& spheres, std::span<const double> radii) {
  double sum = 0;
  for (std::size_t i = 0; i < spheres.size(); ++i) sum += std::abs(spheres[i].radius - radii[i]);
  return sum;
}

}  // namespace

std::vector<FittedSphere> find_spheres(const Cloud& cloud, std::span<const double> radii) {
  std::vector<SurfaceElement> elements = surface_elements(cloud);
  std::vector<FittedSphere> spheres;
  for (const double radius : radii) {
    const auto sphere = find_sphere(cloud, elements, radius);
    if (!sphere) {
      throw Error(fmt::format("no sphere of diameter {:g} mm is seen{}", 2 * radius,
                              spheres.empty() ? "" : " beside the first"));
    }
    std::erase_if(elements, [&](const SurfaceElement& element) {
      return signed_distance(*sphere, element.point) < 0.2 * radius;
    });
    spheres.push_back(*sphere);
  }
  std::vector<FittedSphere> reversed(spheres.rbegin(), spheres.rend());
  return misfit(reversed, radii) < misfit(spheres, radii) ? reversed : spheres;
}

std::vector<MeasuredPoint> points_on(const Cloud& cloud, const FittedSphere& sphere,
                                     double widest_angle) {
  const double widest = sphere.radius * std::sin(widest_angle);
  std::vector<MeasuredPoint> points;
  for (int row = 0; row < cloud.size().height; ++row) {
    for (int column = 0; column < cloud.size().width; ++column) {
      const std::optional<MeasuredPoint> point = point_at(cloud, nullptr, column, row);
      if (!point) continue;
      const Vector ray = point->position.normalized();
      if (ray.cross(sphere.centre).norm() <= widest) points.push_back(*point);
    }
  }
  return points;
}

}  // namespace slipstream
