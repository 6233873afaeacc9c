// Pairs of views of virtual objects, joined without a start, or refused.
#include "merge/pair_alignment.h"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/cloud_file.h"
#include "tests/merge/virtual_shots.h"
#include "tests/shared_data.h"

namespace slipstream::pair_alignment_test {

struct Pair {
  PreparedView first, second;
  Eigen::Isometry3d truth;
};

Pair pair_of(const Mesh& object, const Eigen::Isometry3d& first_pose,
             const Eigen::Isometry3d& second_pose, double noise, unsigned seed = 1) {
  const MeshTree tree(object);
  std::vector<View> views{view_at(tree, first_pose, noise, 2 * seed),
                          view_at(tree, second_pose, noise, 2 * seed + 1)};
  const float cell = keypoint_cell(views);
  return {PreparedView(std::move(views[0]), cell), PreparedView(std::move(views[1]), cell),
          first_pose * second_pose.inverse()};
}

double degrees_off(const Eigen::Isometry3d& pose, const Eigen::Isometry3d& truth) {
  return Eigen::AngleAxisd((truth.inverse() * pose).linear()).angle() * 180 / std::numbers::pi;
}

void expect_right(const PairAlignment& found, const Pair& pair) {
  ASSERT_TRUE(found.joined()) << found.reason;
  EXPECT_LT(degrees_off(found.pose, pair.truth), 0.05);
  EXPECT_LT((found.pose * pair.second.middle() - pair.truth * pair.second.middle()).norm(), 0.1);
}

const Eigen::Isometry3d front = before_camera(Eigen::Isometry3d::Identity());
const Eigen::Isometry3d other =
    before_camera(turned({0.1, 1, 0.05}, 40) * turned(Eigen::Vector3d::UnitZ(), 20));

TEST(AlignViews, JoinsTwoSidesOfAStatueWithoutAStart) {
  const Pair pair = pair_of(large_statue(), front, other, 0.1);
  expect_right(align_views(pair.first, pair.second), pair);
}

TEST(AlignViews, JoinsAReliefFromTwoSides) {
  const Pair pair = pair_of(relief(), front, before_camera(turned({0, 1, 0.4}, 25)), 0.1);
  expect_right(align_views(pair.first, pair.second), pair);
}

class Sliding : public testing::TestWithParam<Mesh (*)()> {};

TEST_P(Sliding, IsRefused) {
  const Pair pair = pair_of(GetParam()(), front, before_camera(turned({1, 0.4, 0}, 15)), 0.1);
  const PairAlignment found = align_views(pair.first, pair.second);
  EXPECT_EQ(found.refusal, Refusal::slides) << found.reason;

  // Also from the true pose.
  EXPECT_EQ(refine_alignment(pair.first, pair.second, pair.truth).refusal, Refusal::slides);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Sliding,
                         testing::Values([] { return plate([](double, double) { return 0.0; }); },
                                         ball, pipe));

TEST(AlignViews, RefusesAPartThatRepeatsItself) {
  const Pair pair = pair_of(ring_of_cones(4), front, before_camera(turned({0, 1, 0}, 15)), 0.1);
  const PairAlignment found = align_views(pair.first, pair.second);
  EXPECT_EQ(found.refusal, Refusal::repeats) << found.reason;
}

TEST(AlignViews, RefusesViewsOfDifferentObjects) {
  std::vector<View> views{view_at(MeshTree(large_statue()), front, 0.1, 1),
                          view_at(MeshTree(relief()), front, 0.1, 2)};
  const float cell = keypoint_cell(views);
  const PreparedView first(std::move(views[0]), cell), second(std::move(views[1]), cell);
  const PairAlignment found = align_views(first, second);
  EXPECT_FALSE(found.joined());
  EXPECT_FALSE(found.reason.empty());
}

TEST(RefineAlignment, FindsThePoseFromFifteenDegreesOff) {
  const Pair pair = pair_of(relief(), front, before_camera(turned({0, 1, 0.4}, 12)), 0.05);
  const Eigen::Isometry3d start = pair.truth * Eigen::Translation3d(pair.second.middle()) *
                                  turned({0, 0, 1}, 3) *
                                  Eigen::Translation3d(-pair.second.middle());
  expect_right(refine_alignment(pair.first, pair.second, start), pair);
}

TEST(RefineAlignment, ExpectsTheDistancesThatTheNoiseMakes) {
  const Pair pair = pair_of(relief(), front, other, 0.1);
  const PairAlignment found = alignment_at(pair.first, pair.second, pair.truth);
  EXPECT_NEAR(found.median / found.noise, 1, 0.1);
}

/// All scenes, overlaps and noises of the table in docs/how-to/merge.md.
class Table : public testing::TestWithParam<double> {};

TEST_P(Table, HasNoWrongPose) {
  const std::vector<std::pair<std::string, Mesh>> scenes{
      {"statue", large_statue()}, {"relief", relief()}, {"cones", ring_of_cones(3)}};
  int joined = 0, pairs = 0;
  for (const auto& [name, mesh] : scenes) {
    for (int k = 0; k < 4; ++k) {
      SCOPED_TRACE(name + " " + std::to_string(k));
      const Eigen::Isometry3d turn = turned({0.1 * k, 1, 0.2}, 20 + 9 * k);
      const Pair pair =
          pair_of(mesh, front, before_camera(turn), GetParam(), static_cast<unsigned>(k + 1));
      const PairAlignment found = align_views(pair.first, pair.second);
      ++pairs;
      if (!found.joined()) continue;
      ++joined;
      expect_right(found, pair);
    }
  }
  EXPECT_GE(joined, pairs / 2);
}

INSTANTIATE_TEST_SUITE_P(Noises, Table, testing::Values(0.02, 0.1, 0.3));

TEST(AlignViews, FindsTheTurnOfARealTurntable) {
  const std::filesystem::path folder = shared_data() / "sltk";
  if (!exists(folder)) GTEST_SKIP() << folder << " is missing";

  std::vector<View> views;
  for (const char* name : {"scan_0020_cloud.ply", "scan_0021_cloud.ply"}) {
    StoredCloud stored = read_cloud(folder / name);
    Cloud& cloud = stored.cloud;

    // The object alone: the wall behind it stands still.
    for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
      const Eigen::Vector3d point = position_at(cloud, column, row);
      const bool inside = std::abs(point.z()) < 730 && point.x() > -290 && point.x() < -60;
      if (!inside || point.y() > 40) cloud.reject(column, row, Validity::outside_region);
    });
    views.push_back(view_of(cloud, nullptr, name));
  }

  const float cell = keypoint_cell(views);
  const PreparedView first(std::move(views[0]), cell), second(std::move(views[1]), cell);
  const PairAlignment found = align_views(first, second);
  ASSERT_TRUE(found.joined()) << found.reason;
  EXPECT_NEAR(degrees_off(found.pose, Eigen::Isometry3d::Identity()), 1.381, 0.02);
  EXPECT_LT(found.rms, 0.18);
}

}  // namespace slipstream::pair_alignment_test
