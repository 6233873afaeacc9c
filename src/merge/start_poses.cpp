#include "merge/start_poses.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "merge/pair_alignment.h"

namespace slipstream {
namespace {

using Poses = std::vector<std::optional<Eigen::Isometry3d>>;

/// Mean over the views with a pose of the largest overlap with another view, see PoseReading.
double mean_overlap(const std::vector<PreparedView>& views, const Poses& poses) {
  // 1. The largest overlap of each view.
  std::vector<double> largest(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t k = i + 1; k < views.size(); ++k) {
      if (!poses[i] || !poses[k]) continue;
      const Eigen::Isometry3d pose = poses[i]->inverse() * *poses[k];
      const double overlap =
          (overlap_at(views[i], views[k], pose) + rough_overlap_at(views[i], views[k], pose)) / 2;
      largest[i] = std::max(largest[i], overlap);
      largest[k] = std::max(largest[k], overlap);
    }
  }

  // 2. Their mean.
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!poses[i]) continue;
    sum += largest[i];
    ++count;
  }
  return sum / std::max(count, 1.0);
}

}  // namespace

std::vector<PoseReading> pose_readings(const std::vector<PreparedView>& views,
                                       const Poses& scalar_last, const Poses& scalar_first,
                                       bool are_matrices) {
  std::vector<PoseReading> readings;
  for (const bool first : {false, true}) {
    if (are_matrices && first) continue;
    for (const bool inverted : {false, true}) {
      PoseReading reading{.poses = first ? scalar_first : scalar_last};
      for (auto& pose : reading.poses) {
        if (pose && inverted) *pose = pose->inverse();
      }
      if (!are_matrices) reading.sense = first ? "quaternion w x y z, " : "quaternion x y z w, ";
      reading.sense += inverted ? "from the model's frame to the view's"
                                : "from the view's frame to the model's";
      reading.overlap = mean_overlap(views, reading.poses);
      readings.push_back(std::move(reading));
    }
  }

  std::stable_sort(
      readings.begin(), readings.end(),
      [](const PoseReading& a, const PoseReading& b) { return a.overlap > b.overlap; });
  return readings;
}

}  // namespace slipstream
