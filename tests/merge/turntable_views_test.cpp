// Views of a virtual statue that turns in front of a camera.
#include "merge/turntable_views.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "base/numbers.h"
#include "base/statistics.h"
#include "tests/merge/virtual_shots.h"

namespace slipstream::turntable_views_test {

constexpr std::size_t view_count = 12;

/// A table in front of a camera that looks down a little.
Turntable true_table() {
  Turntable table{.direction = Eigen::Vector3d(0.03, -0.97, -0.2).normalized(),
                  .point = {4, 0, 603}};
  for (std::size_t view = 0; view < view_count; ++view) {
    table.angles.push_back(static_cast<double>(view) * 30 * degree);
  }
  return table;
}

/// Views of an object that turns on the table; `to_first`: each view's true pose.
std::vector<PreparedView> views_of(const MeshTree& object,
                                   const std::vector<Eigen::Isometry3d>& to_first, double noise,
                                   unsigned seed) {
  std::vector<View> views;
  for (const Eigen::Isometry3d& pose : to_first) {
    views.push_back(view_at(object, pose.inverse() * before_camera(Eigen::Isometry3d::Identity()),
                            noise, ++seed));
  }

  const float cell = keypoint_cell(views);
  std::vector<PreparedView> prepared;
  for (View& view : views) prepared.emplace_back(std::move(view), cell);
  return prepared;
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
  const Eigen::Isometry3d hand = Eigen::Translation3d(1.5, 0.3, -1) *
                                 Eigen::Translation3d(table.point) * turned({0.2, -1, 0.1}, 2) *
                                 Eigen::Translation3d(-table.point);

  FoundTable found;
  for (std::size_t k = 0; k < view_count; ++k) {
    const Eigen::Isometry3d by_hand =
        moved > 0 && k >= moved ? hand : Eigen::Isometry3d(Eigen::Isometry3d::Identity());
    found.truth.push_back((pose_on(table, k, 0) * by_hand).inverse());
  }
  found.views = views_of(MeshTree(large_statue()), found.truth, noise, 0);

  const JointAlignment joint = join_views(found.views);
  EXPECT_EQ(joint.joined(), view_count);

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

/// A heap of seven pebbles, 180 mm high.
Mesh pebbles() {
  Mesh mesh;
  append_ellipsoid(mesh, {0, 0, 0}, {45, 75, 40});
  append_ellipsoid(mesh, {25, 45, 20}, {30, 22, 30});
  append_ellipsoid(mesh, {-35, 10, -15}, {25, 30, 20});
  append_ellipsoid(mesh, {15, -50, -30}, {30, 25, 28});
  append_ellipsoid(mesh, {-10, -30, 38}, {18, 30, 16});
  append_ellipsoid(mesh, {38, -10, -8}, {16, 24, 22});
  append_ellipsoid(mesh, {-25, 60, 12}, {20, 18, 22});
  return mesh;
}

/// The turntable that the surfaces of neighbouring views give, from a start that is a little off.
Turntable refined_table(const MeshTree& object, double noise, unsigned seed) {
  const Turntable truth = true_table();
  std::vector<PairPose> pairs;
  std::vector<Eigen::Isometry3d> to_first;
  for (std::size_t k = 0; k < view_count; ++k) {
    to_first.push_back(pose_on(truth, 0, k));
    for (std::size_t apart = 1; apart <= 2; ++apart) {
      const auto [first, second] = std::minmax({k, (k + apart) % view_count});
      pairs.push_back({.first = first, .second = second, .centre = truth.point});
    }
  }
  const std::vector<PreparedView> views = views_of(object, to_first, noise, 100 * seed);

  TurntableFit fit{.table = truth, .agrees = std::vector<bool>(pairs.size(), true)};
  fit.table.step = 30 * degree;
  fit.table.point += Eigen::Vector3d(0.1, 0, -0.1);
  refine_on_surfaces(views, pairs, fit);
  return fit.table;
}

struct SigmaCase {
  std::string name;
  std::vector<double> noises;  ///< mm
  unsigned seeds = 0;          ///< of each noise and object
  double least = 0, most = 0;  ///< RMS of the errors in their standard deviations
};

class TurntableViewsSigma : public testing::TestWithParam<SigmaCase> {};

TEST_P(TurntableViewsSigma, IsThatOfTheErrors) {
  const Turntable truth = true_table();
  Squares direction, point, step;
  for (const Mesh& mesh : {large_statue(), pebbles()}) {
    const MeshTree object(mesh);
    for (const double noise : GetParam().noises) {
      for (unsigned seed = 0; seed < GetParam().seeds; ++seed) {
        const Turntable found = refined_table(object, noise, seed);
        const Eigen::Vector3d off = found.point - truth.point;
        const Eigen::Vector3d shift = off - truth.direction.dot(off) * truth.direction;
        const Eigen::Vector3d tilt = truth.direction.cross(found.direction);

        // Each has two components; the standard deviations are of the less known one.
        direction.add(tilt.squaredNorm() / std::pow(found.direction_sigma, 2) / 2);
        point.add(shift.squaredNorm() / std::pow(found.point_sigma, 2) / 2);
        step.add(std::pow((*found.step - 30 * degree) / found.step_sigma, 2));
      }
    }
  }

  for (const Squares& errors : {direction, point, step}) {
    EXPECT_GT(errors.rms(), GetParam().least);
    EXPECT_LT(errors.rms(), GetParam().most);
  }
}

std::string name_of(const testing::TestParamInfo<SigmaCase>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(Day, TurntableViewsSigma,
                         testing::Values(SigmaCase{"two", {0.1}, 1, 0.2, 2}), name_of);
INSTANTIATE_TEST_SUITE_P(Night, TurntableViewsSigma,
                         testing::Values(SigmaCase{"twenty", {0.05, 0.2}, 5, 0.7, 1.4}), name_of);

}  // namespace slipstream::turntable_views_test
