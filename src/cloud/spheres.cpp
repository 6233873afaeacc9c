#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "base/throw_if-inl.h"
#include "slipstream/measure.h"
#include "slipstream/surface.h"

namespace slipstream {
namespace {

using Vector = Eigen::Vector3d;

constexpr std::size_t least_points = 50;

/// A point of the cloud and its surface normal, towards the camera.
struct SurfaceElement {
  Vector point, normal;
};

/// Subsampled: enough elements for a vote, and few enough to be fast.
std::vector<SurfaceElement> surface_elements(const Cloud& cloud) {
  constexpr double enough = 2e5;

  const Normals normals = smoothed_normals(cloud);
  const auto [width, height] = cloud.size();
  const int step = static_cast<int>(std::ceil(std::sqrt(width * height / enough)));

  std::vector<SurfaceElement> elements;
  for (int row = 0; row < height; row += step) {
    for (int column = 0; column < width; column += step) {
      const Vector normal(normals.x(column, row), normals.y(column, row), normals.z(column, row));
      if (normal.allFinite()) elements.push_back({position_at(cloud, column, row), normal});
    }
  }

  return elements;
}

/// The centre of a sphere with this radius through an element.
Vector vote_of(const SurfaceElement& element, double radius) {
  return element.point - radius * element.normal;
}

/// The centre with the most votes: the mean of the votes in the fullest cell of a grid.
std::optional<Vector> centre_by_votes(const std::vector<SurfaceElement>& elements, double radius,
                                      double cell) {
  struct Votes {
    int count = 0;
    Vector sum = Vector::Zero();
  };

  std::map<std::array<double, 3>, Votes> cells;
  for (const SurfaceElement& element : elements) {
    const Vector vote = vote_of(element, radius), place = (vote / cell).array().floor();
    Votes& votes = cells[{place.x(), place.y(), place.z()}];
    ++votes.count;
    votes.sum += vote;
  }

  const auto fullest =
      std::ranges::max_element(cells, {}, [](const auto& one) { return one.second.count; });
  if (fullest == cells.end()) return std::nullopt;
  return fullest->second.sum / fullest->second.count;
}

std::optional<FittedSphere> sphere_at(const Cloud& cloud, const Vector& centre, double radius) {
  constexpr double sure_angle = 60 * std::numbers::pi / 180;

  // The points whose rays meet the sphere well inside its outline.
  const FittedSphere rough{.centre = centre, .radius = radius};
  std::vector<MeasuredPoint> points = points_in(cloud);
  std::erase_if(points, [&](const MeasuredPoint& point) {
    return !is_on_cap(rough, point.position, sure_angle);
  });

  // At least half of them must lie near it, at most a third of the radius away.
  const std::size_t seen = points.size();
  std::erase_if(points, [&](const MeasuredPoint& point) {
    return std::abs(signed_distance(rough, point.position)) > radius / 3;
  });

  if (points.size() < least_points || points.size() < seen / 2) return std::nullopt;

  // The fitted radius must agree to a tenth.
  try {
    const FittedSphere sphere = fit_sphere(points);
    if (std::abs(sphere.radius - radius) < radius / 10) return sphere;
  } catch (const Error&) {  // they do not determine a sphere
  }

  return std::nullopt;
}

/// The best-supported sphere that passes the fit; a failed candidate is removed before the next.
std::optional<FittedSphere> find_sphere(const Cloud& cloud, std::vector<SurfaceElement> elements,
                                        double radius) {
  constexpr int most_places = 20;

  const double cell = radius / 3;
  for (int place = 0; place < most_places; ++place) {
    const std::optional<Vector> centre = centre_by_votes(elements, radius, cell);
    if (!centre) return std::nullopt;

    if (const auto sphere = sphere_at(cloud, *centre, radius)) return sphere;

    std::erase_if(elements, [&](const SurfaceElement& element) {
      return (vote_of(element, radius) - *centre).norm() <= cell;
    });
  }

  return std::nullopt;
}

/// Difference between the spheres' radii and `radii`, mm.
double misfit(const std::vector<FittedSphere>& spheres, std::span<const double> radii) {
  double sum = 0;
  for (std::size_t i = 0; i < spheres.size(); ++i) sum += std::abs(spheres[i].radius - radii[i]);
  return sum;
}

}  // namespace

std::vector<FittedSphere> find_spheres(const Cloud& cloud, std::span<const double> radii) {
  std::vector<SurfaceElement> elements = surface_elements(cloud);

  std::vector<FittedSphere> spheres;

  // The smaller first: if one is found for it, the other remains for the larger.
  std::vector<double> ascending(radii.begin(), radii.end());
  std::sort(ascending.begin(), ascending.end());

  for (const double radius : ascending) {
    const auto sphere = find_sphere(cloud, elements, radius);
    throw_if(!sphere, "no sphere of diameter {:g} mm found{}", 2 * radius,
             spheres.empty() ? "" : " beside the first");

    // Its own points do not vote for the other sphere.
    std::erase_if(elements, [&](const SurfaceElement& element) {
      return signed_distance(*sphere, element.point) < 0.2 * radius;
    });

    spheres.push_back(*sphere);
  }

  // With similar radii either sphere may have been found first.
  const std::vector<FittedSphere> reversed(spheres.rbegin(), spheres.rend());
  return misfit(reversed, radii) < misfit(spheres, radii) ? reversed : spheres;
}

bool is_on_cap(const FittedSphere& sphere, const Vector& point, double widest_angle) {
  return point.normalized().cross(sphere.centre).norm() <= sphere.radius * std::sin(widest_angle);
}

}  // namespace slipstream
