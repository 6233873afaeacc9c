#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "slipstream/cloud/cloud.h"
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
};

/// A line for people.
std::string text_of(const ObjectTrack& track);

/// Looks for it cloud by cloud.
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
