#pragma once

#include <deque>

#include "slipstream/measure.h"

namespace slipstream {

/// Known shape to find in every cloud: a sphere, or the plane with the most points.
struct TrackedShape {
  std::optional<double> radius{};  ///< of the sphere, mm; nullopt: a plane
};

/// Parses "sphere:RADIUS" or "plane". Throws Error for anything else.
TrackedShape tracked_shape_named(std::string_view name);

/// Position of a shape in the last cloud that contained it.
struct ObjectTrack {
  TrackedShape shape{};
  std::uint64_t found = 0;   ///< clouds that contained it
  std::uint64_t looked = 0;  ///< clouds searched
  std::uint64_t missed = 0;  ///< clouds skipped while another was searched
  /// Centre of the sphere, or intersection of the plane with the camera's axis, mm.
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< plane, towards the camera; else zero
  Residuals residuals{};
  /// mm/s, from the last clouds; along the normal of a plane. Zero before the third cloud.
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();

  template <class Visit>
  void for_each_figure(const Visit& visit) const {
    visit("found", found);
    visit("looked", looked);
    visit("missed", missed);
    visit(shape.radius ? "centre_mm" : "place_mm", place);
    visit("residual_mm", residuals.rms);
    visit("points", residuals.points);
    visit("velocity_mm_per_s", velocity);
    visit("speed_mm_per_s", velocity.norm());
    if (!shape.radius) visit("normal", normal);
  }
};

/// Progress of a model built from the clouds.
struct ModelStatistics {
  int views = 0;             ///< merged
  int left_out = 0;          ///< rejected because they did not fit
  std::uint64_t missed = 0;  ///< skipped while another was merged
  std::size_t points = 0;    ///< of the model, confirmed or not
  double rms = 0;            ///< distance of the last view from the model, mm
  double milliseconds = 0;   ///< per view, on average

  template <class Visit>
  void for_each_figure(const Visit& visit) const {
    visit("views", views);
    visit("left_out", left_out);
    visit("missed", missed);
    visit("points", points);
    visit("rms_mm", rms);
    visit("view_ms", milliseconds);
  }
};

/// One line for people.
std::string text_of(const ObjectTrack& track);
std::string text_of(const ModelStatistics& model);

/// Tracks a shape cloud by cloud.
class ObjectTracker {
 public:
  explicit ObjectTracker(const TrackedShape& shape) : track_{.shape = shape} {}

  /// `seconds`: time in the middle of the cloud's frames, from any origin. A sphere is fitted with
  /// its known radius at the predicted position, or searched for in the whole cloud.
  void look(const Cloud& cloud, double seconds);
  [[nodiscard]] const ObjectTrack& track() const { return track_; }

 private:
  struct Moment {
    double seconds = 0;
    Eigen::Vector3d place;
  };

  [[nodiscard]] FittedSphere sphere_in(const Cloud& cloud, double seconds) const;
  void fit(const Cloud& cloud, double seconds);
  [[nodiscard]] Eigen::Vector3d velocity() const;

  ObjectTrack track_;
  std::deque<Moment> moments_;
};

}  // namespace slipstream
