#pragma once

#include <deque>

#include "slipstream/cloud/measure.h"

namespace slipstream {

/// A known thing that is looked for in every cloud: a sphere, or the plane of most points.
struct TrackedShape {
  std::optional<double> radius{};  ///< of the sphere, mm; none: a plane
};

/// Of "sphere:RADIUS" or "plane". Throws Error for anything else.
TrackedShape tracked_shape_named(std::string_view name);

/// Where it was in the last cloud that held it.
struct ObjectTrack {
  TrackedShape shape{};
  std::uint64_t found = 0;   ///< clouds that held it
  std::uint64_t looked = 0;  ///< in which it was looked for
  std::uint64_t missed = 0;  ///< that came while another was looked at
  /// The sphere's centre, or where the plane meets the camera's axis, mm.
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of the plane, towards the camera; or zero
  Residuals residuals{};
  /// mm/s, by the clouds of the last moments; a plane's is along its normal. Zero before three.
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

/// How a model of the clouds comes on.
struct ModelStatistics {
  int views = 0;             ///< taken in
  int left_out = 0;          ///< that did not fit
  std::uint64_t missed = 0;  ///< that came while another was taken in
  std::size_t points = 0;    ///< of the model, sure or not
  double rms = 0;            ///< of the last view from the model, mm
  double milliseconds = 0;   ///< that a view took, on average

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

/// A line for people.
std::string text_of(const ObjectTrack& track);
std::string text_of(const ModelStatistics& model);

/// Looks for a shape cloud by cloud.
class ObjectTracker {
 public:
  explicit ObjectTracker(const TrackedShape& shape) : track_{.shape = shape} {}

  /// `seconds`: the time in the middle of the cloud's frames, from anywhere. A sphere is fitted
  /// with its radius, near where it is to be expected, or looked for anew.
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
