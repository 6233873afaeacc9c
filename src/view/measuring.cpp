#include "view/measuring.h"

#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <fmt/ranges.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "slipstream/error.h"
#include "view/orbit_camera.h"

namespace slipstream::view {
namespace {

/// Calls `visit(column, row, place on the picture, distance from the eye)` for each visible point.
template <class Visit>
void for_each_drawn(const CloudOnPicture& shown, const Visit& visit) {
  const Cloud& cloud = shown.cloud;
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (std::isnan(cloud.z(column, row))) return;

    const glm::vec4 clip =
        shown.clip * glm::vec4(cloud.x(column, row), cloud.y(column, row), cloud.z(column, row), 1);

    if (const auto place = pixel_of(clip, shown.picture)) visit(column, row, *place, clip.w);
  });
}

std::string text_of(const Residuals& residuals) {
  std::string text = fmt::format("rms {:.3f} mm, largest {:.3f} mm, {} points", residuals.rms,
                                 residuals.largest, residuals.points);

  if (residuals.outliers != 0) text += fmt::format(", {} outliers ignored", residuals.outliers);
  if (residuals.noise) text += fmt::format("; noise alone gives {:.3f} mm", *residuals.noise);

  return text;
}

std::string text_of(const FittedPlane& plane) {
  return fmt::format("Plane: {}; normal {:.4f}", text_of(plane.residuals),
                     fmt::join(plane.normal, " "));
}

std::string text_of(const FittedSphere& sphere) {
  return fmt::format("Sphere: radius {:.3f} mm, sigma {:.3f} mm; {}", sphere.radius,
                     sphere.radius_sigma, text_of(sphere.residuals));
}

template <class Fit>
std::string fitted(const char* shape, const Fit& fit, std::span<const MeasuredPoint> points) try {
  return text_of(fit(points, std::nullopt));
} catch (const Error& error) {
  return fmt::format("No {}: {}", shape, error.what());
}

}  // namespace

std::optional<MeasuredPoint> point_under(const CloudOnPicture& shown, const glm::vec2& place,
                                         float reach) {
  float nearest = std::numeric_limits<float>::infinity();
  std::optional<MeasuredPoint> found;

  for_each_drawn(shown, [&](int column, int row, const glm::vec2& drawn, float distance) {
    if (distance >= nearest || glm::distance(drawn, place) > reach) return;

    nearest = distance;
    found = point_at(shown.cloud, shown.uncertainty, column, row);
  });

  return found;
}

std::vector<MeasuredPoint> points_between(const CloudOnPicture& shown, const glm::vec2& corner,
                                          const glm::vec2& opposite) {
  const glm::vec2 low = glm::min(corner, opposite), high = glm::max(corner, opposite);

  std::vector<MeasuredPoint> points;
  for_each_drawn(shown, [&](int column, int row, const glm::vec2& drawn, float) {
    if (drawn.x < low.x || drawn.y < low.y || drawn.x > high.x || drawn.y > high.y) return;
    if (const auto point = point_at(shown.cloud, shown.uncertainty, column, row)) {
      points.push_back(*point);
    }
  });

  return points;
}

void add_end(Measured& measured, const MeasuredPoint& point, const FramePose* frame) {
  if (measured.ends.size() == 2) measured.ends.clear();
  measured.ends.push_back(point);

  measured.lines = {text_of(point, frame)};
  if (measured.ends.size() < 2) return;

  const Distance length = distance(measured.ends[0], measured.ends[1]);
  measured.lines = {fmt::format("Distance: {:.3f} mm", length.length)};
  if (length.sigma) measured.lines[0] += fmt::format(", sigma {:.3f} mm", *length.sigma);
}

void fit_shapes(Measured& measured, std::span<const MeasuredPoint> points, const FramePose* frame) {
  const auto plane = [frame](std::span<const MeasuredPoint> of, std::optional<double> left_out) {
    FittedPlane fit = fit_plane(of, left_out);
    if (frame != nullptr) fit.normal = frame->transform.linear() * fit.normal;
    return fit;
  };

  measured.ends.clear();
  measured.lines = {fitted("plane", plane, points), fitted("sphere", fit_sphere, points)};
}

std::string text_of(const MeasuredPoint& point, const FramePose* frame) {
  Eigen::Vector3d at = point.position;
  if (frame != nullptr) at = frame->transform * at;
  std::string text = fmt::format("X {:.2f}  Y {:.2f}  Z {:.2f} mm", at.x(), at.y(), at.z());

  if (frame != nullptr) {
    text += fmt::format(" in {}", frame->to);
    if (point.sigma) text += fmt::format(",  sigma along the ray {:.3f} mm", point.sigma->norm());
    return text;
  }
  if (point.sigma) text += fmt::format(",  sigma of Z {:.3f} mm", point.sigma->z());
  return text;
}

}  // namespace slipstream::view
