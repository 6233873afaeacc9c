#include "live/object_tracker.h"

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "base/numbers.h"
#include "slipstream/error.h"

namespace slipstream {
namespace {

/// All points of a cloud, or about this many, evenly spaced.
std::vector<MeasuredPoint> thinned(std::vector<MeasuredPoint> points) {
  constexpr std::size_t most = 20'000;
  const std::size_t step = points.size() / most + 1;
  for (std::size_t i = 0; i * step < points.size(); ++i) points[i] = points[i * step];
  points.resize((points.size() + step - 1) / step);
  return points;
}

}  // namespace

TrackedShape tracked_shape_named(std::string_view name) {
  constexpr std::string_view sphere = "sphere:";

  if (name == "plane") return {};
  if (name.starts_with(sphere)) {
    const auto radius = number_in<double>(name.substr(sphere.size()));
    if (radius && *radius > 0 && *radius <= 1e5) return {radius};
  }

  throw Error(
      fmt::format("cannot track '{}'; use sphere:RADIUS (mm, at most 100000) or plane", name));
}

std::string text_of(const ObjectTrack& track) {
  const std::string name = track.shape.radius ? "sphere" : "plane";
  const std::string seen =
      fmt::format("found in {} of {} clouds, {} missed", track.found, track.looked, track.missed);
  if (track.found == 0) return fmt::format("{}: {}", name, seen);

  const auto vector = [](const Eigen::Vector3d& v, int digits) {
    return fmt::format("{:.{}f} {:.{}f} {:.{}f}", v.x(), digits, v.y(), digits, v.z(), digits);
  };
  const std::string where = track.shape.radius
                                ? "at " + vector(track.place, 3) + " mm"
                                : fmt::format("at {:.3f} mm on the camera's axis, normal {}",
                                              track.place.z(), vector(track.normal, 4));

  return fmt::format("{} {}, residual {:.3f} mm, {:.2f} mm/s; {}", name, where, track.residuals.rms,
                     track.velocity.norm(), seen);
}

std::string text_of(const ModelStatistics& model) {
  return fmt::format(
      "model: {} points of {} views, RMS {:.3f} mm from the last; {} did not fit, {} missed; "
      "{:.1f} ms per view",
      model.points, model.views, model.rms, model.left_out, model.missed, model.milliseconds);
}

void ObjectTracker::look(const Cloud& cloud, double seconds) {
  ++track_.looked;
  try {
    fit(cloud, seconds);
  } catch (const Error&) {  // the shape is missing, or too little of it is visible
    moments_.clear();
    return;
  }

  ++track_.found;
  constexpr std::size_t most_moments = 8;

  // Time that does not advance comes from another source; old positions say nothing about it.
  if (!moments_.empty() && !(seconds > moments_.back().seconds)) moments_.clear();
  moments_.push_back({seconds, track_.place});
  if (moments_.size() > most_moments) moments_.pop_front();

  track_.velocity = velocity();
}

FittedSphere ObjectTracker::sphere_in(const Cloud& cloud, double seconds) const {
  // Beyond this angle to the surface normal, rays graze the sphere and depth is unreliable.
  constexpr double sure_angle = 60 * std::numbers::pi / 180;
  // With fewer points near the predicted position, the sphere counts as lost.
  constexpr std::size_t fewest = 50;

  const double radius = *track_.shape.radius;
  FittedSphere near{.centre = {}, .radius = radius, .residuals = {}};

  // Points on the cap seen by the camera, within a fifth of the radius of the surface.
  const auto points_near = [&] {
    std::vector<MeasuredPoint> points = points_in(cloud);
    std::erase_if(points, [&](const MeasuredPoint& point) {
      return !is_on_cap(near, point.position, sure_angle) ||
             std::abs(signed_distance(near, point.position)) > radius / 5;
    });
    return thinned(std::move(points));
  };

  // Try the predicted position first: the last one, moved on at the last velocity.
  if (!moments_.empty()) {
    near.centre = track_.place + (seconds - moments_.back().seconds) * track_.velocity;
    const std::vector<MeasuredPoint> points = points_near();
    if (points.size() >= fewest) return fit_sphere_near(points, near);
  }

  // Lost: search the whole cloud.
  near.centre = find_spheres(cloud, std::array{radius}).front().centre;
  return fit_sphere_near(points_near(), near);
}

void ObjectTracker::fit(const Cloud& cloud, double seconds) {
  if (track_.shape.radius) {
    const FittedSphere sphere = sphere_in(cloud, seconds);
    track_.place = sphere.centre;
    track_.residuals = sphere.residuals;
    return;
  }

  const FittedPlane plane = fit_plane(thinned(points_in(cloud)));
  // Where the camera's axis (x = y = 0) meets the plane.
  const double depth = plane.normal.dot(plane.centre) / plane.normal.z();
  track_.place = {0, 0, depth};
  track_.normal = plane.normal;
  track_.residuals = plane.residuals;
}

/// Slope of a least-squares line through the last positions.
Eigen::Vector3d ObjectTracker::velocity() const {
  if (moments_.size() < 3) return Eigen::Vector3d::Zero();

  // Times relative to their mean, so that the slope needs no intercept.
  const double first = moments_.front().seconds, count = static_cast<double>(moments_.size());
  double mean = 0;
  for (const Moment& moment : moments_) mean += (moment.seconds - first) / count;

  double squares = 0;
  Eigen::Vector3d products = Eigen::Vector3d::Zero();
  for (const Moment& moment : moments_) {
    const double since = moment.seconds - first - mean;
    squares += since * since;
    products += since * (moment.place - moments_.front().place);
  }

  // Motion within a plane cannot be seen, so only the part along its normal counts.
  const Eigen::Vector3d slope = products / squares;
  return track_.shape.radius ? slope : slope.dot(track_.normal) * track_.normal;
}

}  // namespace slipstream
