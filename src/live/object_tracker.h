#pragma once

#include <deque>

#include "slipstream/cloud.h"
#include "slipstream/live_pipeline.h"
#include "slipstream/measure.h"

namespace slipstream {

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
