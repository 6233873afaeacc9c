// Readings of lists of poses whose convention is unknown.
#include "merge/start_poses.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/merge/virtual_shots.h"

namespace slipstream::start_poses_test {

TEST(StartPosesPoseReadings, NeedNoOverlapOfViewsThatFollowEachOther) {
  // The view between both others shows the back of the object.
  const MeshTree object(large_statue());
  std::vector<View> views;
  std::vector<std::optional<Eigen::Isometry3d>> poses;
  for (const double degrees : {0, 180, 25}) {
    const Eigen::Isometry3d pose = before_camera(turned({0, 1, 0}, degrees));
    views.push_back(view_at(object, pose, 0.05, static_cast<unsigned>(views.size())));
    poses.emplace_back(pose.inverse());
  }

  const float cell = keypoint_cell(views);
  std::vector<PreparedView> prepared;
  for (View& view : views) prepared.emplace_back(std::move(view), cell);

  const std::vector<PoseReading> readings = pose_readings(prepared, poses, poses, true);
  ASSERT_EQ(readings.size(), 2U);
  EXPECT_EQ(readings[0].sense, "from the view's frame to the model's");
  EXPECT_GT(readings[0].overlap, 0.3);
  EXPECT_LT(readings[1].overlap, readings[0].overlap);
}

}  // namespace slipstream::start_poses_test
