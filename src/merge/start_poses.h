#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "merge/prepared_view.h"

namespace slipstream {

/// The poses of a list in one reading of it.
struct PoseReading {
  std::string sense{};  ///< "quaternion x y z w, from the view's frame", ...
  std::vector<std::optional<Eigen::Isometry3d>> poses{};
  /// Mean over the views with a pose of the largest overlap with another view. Half of it is the
  /// overlap at the poses as they are, which tells readings apart; half is the overlap at poses
  /// that may be off by a few cells of the keypoints.
  double overlap = 0;
};

/// The readings of a list whose convention is unknown, the one that brings most surfaces of the
/// views together first. `scalar_last`, `scalar_first`: each view's pose by both orders of the
/// quaternion; equal if it was a matrix. Both directions of the poses are tried, too.
std::vector<PoseReading> pose_readings(
    const std::vector<PreparedView>& views,
    const std::vector<std::optional<Eigen::Isometry3d>>& scalar_last,
    const std::vector<std::optional<Eigen::Isometry3d>>& scalar_first, bool are_matrices);

}  // namespace slipstream
