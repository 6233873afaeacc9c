#include "merge/start_poses.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "merge/pair_alignment.h"

namespace slipstream {
namespace {

using Poses = std::vector<std::optional<Eigen::Isometry3d>>;

/// Mean overlap of the pairs of views that follow each other, which is enough to tell readings
/// apart.
double mean_overlap(const std::vector<PreparedView>& views, const Poses& poses) {
  double sum = 0, pairs = 0;
  for (std::size_t i = 0; i + 1 < views.size(); ++i) {
    if (!poses[i] || !poses[i + 1]) continue;
    sum += overlap_at(views[i], views[i + 1], poses[i]->inverse() * *poses[i + 1]);
    ++pairs;
  }
  return sum / std::max(pairs, 1.0);
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
