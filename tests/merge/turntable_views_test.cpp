// Views of a virtual statue that turns in front of a camera.
#include "merge/turntable_views.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "base/numbers.h"
#include "tests/merge/virtual_shots.h"

namespace slipstream::turntable_views_test {

constexpr int view_count = 12;

/// A table in front of a camera that looks down a little.
Turntable true_table() {
  Turntable table{.direction = Eigen::Vector3d(0.03, -0.97, -0.2).normalized(),
                  .point = {4, 0, 603}};
  for (int view = 0; view < view_count; ++view) table.angles.push_back(view * 30 * degree);
  return table;
}

/// What was found, and the poses that are right.
struct FoundTable {
  std::vector<PreparedView> views;
  std::vector<Eigen::Isometry3d> truth;  ///< each view's points to the first view's frame
  TurntableFit fit;
};

/// `moved`: the view before which a hand moved the statue; 0: none.
FoundTable found_table(double noise, std::size_t moved = 0) {
  const Turntable table = true_table();
  const MeshTree statue(large_statue());
  const Eigen::Isometry3d first = before_camera(Eigen::Isometry3d::Identity());
  const Eigen::Isometry3d hand = Eigen::Translation3d(1.5, 0.3, -1) *
                                 Eigen::Translation3d(table.point) * turned({0.2, -1, 0.1}, 2) *
                                 Eigen::Translation3d(-table.point);

  FoundTable found;
  std::vector<View> views;
  for (int k = 0; k < view_count; ++k) {
    const Eigen::Isometry3d by_hand = moved > 0 && k >= static_cast<int>(moved)
                                          ? hand
                                          : Eigen::Isometry3d(Eigen::Isometry3d::Identity());
    const Eigen::Isometry3d onward = pose_on(table, k, 0) * by_hand;
    found.truth.push_back(onward.inverse());
    views.push_back(view_at(statue, onward * first, noise, static_cast<unsigned>(k + 1)));
  }

  const float cell = keypoint_cell(views);
  for (View& view : views) found.views.emplace_back(std::move(view), cell);
  const JointAlignment joint = join_views(found.views);
  EXPECT_EQ(joint.joined(), static_cast<std::size_t>(view_count));

  const std::vector<PairPose> pairs = pair_poses(joint.links);
  found.fit = fit_turntable(view_count, pairs);
  refine_on_surfaces(found.views, pairs, found.fit);
  return found;
}

double axis_error(const FoundTable& found) {
  const Eigen::Vector3d right = true_table().direction, is = found.fit.table.direction;
  return std::atan2(right.cross(is).norm(), right.dot(is));
}

TEST(TurntableViews, GiveAxisStepAndSurface) {
  const FoundTable found = found_table(0.05);
  EXPECT_LT(axis_error(found), 0.02 * degree);
  ASSERT_TRUE(found.fit.table.step);
  EXPECT_NEAR(*found.fit.table.step, 30 * degree, 0.01 * degree);
  EXPECT_FALSE(found.fit.moved);

  // Errors of the poses across the surface, without the noise of the points.
  double squares = 0, count = 0;
  for (std::size_t view = 0; view < found.views.size(); ++view) {
    const View& points = found.views[view].view();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d point = points.points[i].cast<double>();
      const Eigen::Vector3d off = found.fit.poses[view] * point - found.truth[view] * point;
      const Eigen::Vector3d normal = found.truth[view].linear() * points.normals[i].cast<double>();
      squares += std::pow(normal.dot(off), 2);
      ++count;
    }
  }
  EXPECT_LT(std::sqrt(squares / count), 0.03) << "mm";
}

TEST(TurntableViews, NameAViewThatWasMovedByHand) {
  const FoundTable found = found_table(0.05, 7);
  ASSERT_TRUE(found.fit.moved);
  EXPECT_EQ(found.fit.moved->view, 7U);
  EXPECT_TRUE(found.fit.moved->stays);
  EXPECT_LT(axis_error(found), 0.03 * degree);
}

}  // namespace slipstream::turntable_views_test
