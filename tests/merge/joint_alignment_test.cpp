// Several views joined at once.
#include "merge/joint_alignment.h"

#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/merge/virtual_shots.h"

namespace slipstream::joint_alignment_test {

struct Views {
  std::vector<PreparedView> prepared;
  std::vector<Eigen::Isometry3d> truth;  ///< into the first view's frame
};

Views views_of(const std::vector<std::pair<const MeshTree*, Eigen::Isometry3d>>& shots,
               double noise) {
  std::vector<View> views;
  Views all;
  for (const auto& [object, pose] : shots) {
    const std::string name = "view " + std::to_string(views.size() + 1);
    views.push_back(view_at(*object, pose, noise, static_cast<unsigned>(views.size()), name));
    all.truth.push_back(shots.front().second * pose.inverse());
  }
  const float cell = keypoint_cell(views);
  for (View& view : views) all.prepared.emplace_back(std::move(view), cell);
  return all;
}

void expect_right(const JointAlignment& joint, const Views& views, std::size_t view) {
  ASSERT_TRUE(joint.poses[view]) << joint.reasons[view];
  const Eigen::Vector3d& middle = views.prepared[view].middle();
  EXPECT_LT((*joint.poses[view] * middle - views.truth[view] * middle).norm(), 0.1);
  const Eigen::Isometry3d off = views.truth[view].inverse() * *joint.poses[view];
  EXPECT_LT(Eigen::AngleAxisd(off.linear()).angle() * 180 / std::numbers::pi, 0.05);
}

TEST(JointAlignmentJoinViews, ClosesTheLoopAroundAnObject) {
  const MeshTree object(large_statue());
  std::vector<std::pair<const MeshTree*, Eigen::Isometry3d>> shots;
  for (int k = 0; k < 8; ++k) shots.emplace_back(&object, before_camera(turned({0, 1, 0}, 45 * k)));
  const Views views = views_of(shots, 0.05);

  const JointAlignment joint = join_views(views.prepared);
  EXPECT_EQ(joint.joined(), 8U);
  ASSERT_TRUE(joint.loop_error);
  EXPECT_LT(*joint.loop_error, 0.5);
  for (std::size_t i = 0; i < shots.size(); ++i) expect_right(joint, views, i);
}

TEST(JointAlignmentJoinViews, NamesTheViewThatDoesNotFit) {
  const MeshTree object(relief()), stranger(large_statue());
  const Views views = views_of({{&object, before_camera(turned({0, 1, 0}, 0))},
                                {&stranger, before_camera(turned({0, 1, 0}, 10))},
                                {&object, before_camera(turned({0, 1, 0.3}, 15))}},
                               0.05);

  const JointAlignment joint = join_views(views.prepared);
  EXPECT_EQ(joint.joined(), 2U);
  EXPECT_FALSE(joint.poses[1]);
  EXPECT_FALSE(joint.reasons[1].empty());
  expect_right(joint, views, 2);
}

TEST(JointAlignmentJoinViews, StartsFromRoughPoses) {
  const MeshTree object(relief());
  const Views views = views_of({{&object, before_camera(turned({0, 1, 0}, 0))},
                                {&object, before_camera(turned({0, 1, 0.3}, 15))}},
                               0.05);

  JointSettings settings;
  settings.starts = {Eigen::Isometry3d::Identity(), views.truth[1] * turned({0, 0, 1}, 0.5)};
  expect_right(join_views(views.prepared, settings), views, 1);
}

TEST(JointAlignmentJoinViews, StartsFromPosesThatAreOffByACell) {
  const MeshTree object(relief());
  const Views views = views_of({{&object, before_camera(turned({0, 1, 0}, 0))},
                                {&object, before_camera(turned({0, 1, 0.3}, 15))}},
                               0.05);

  JointSettings settings;
  settings.starts = {Eigen::Isometry3d::Identity(),
                     views.truth[1] * Eigen::Translation3d(0, 0, 10)};
  expect_right(join_views(views.prepared, settings), views, 1);
}

TEST(JointAlignmentJoinViews, SaysWhichViewHasNoStart) {
  const MeshTree object(relief());
  const Views views = views_of({{&object, before_camera(turned({0, 1, 0}, 0))},
                                {&object, before_camera(turned({0, 1, 0.3}, 15))},
                                {&object, before_camera(turned({0, 1, 0.3}, 20))}},
                               0.05);

  JointSettings settings;
  settings.starts = {Eigen::Isometry3d::Identity(), views.truth[1], std::nullopt};
  const JointAlignment joint = join_views(views.prepared, settings);
  EXPECT_EQ(joint.joined(), 2U);
  EXPECT_EQ(joint.reasons[2], "no start pose is given for it");
  EXPECT_TRUE(joint.misfits.empty());
}

}  // namespace slipstream::joint_alignment_test
