// Pairs of views of virtual objects, joined without a start, or refused.
#include "merge/pair_alignment.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "base/statistics.h"
#include "geometry/point_fit.h"
#include "slipstream/cloud_file.h"
#include "tests/merge/virtual_shots.h"
#include "tests/shared_data.h"

namespace slipstream::pair_alignment_test {

struct Pair {
  PreparedView first, second;
  Eigen::Isometry3d truth;
};

Pair pair_of(const Mesh& object, const Eigen::Isometry3d& first_pose,
             const Eigen::Isometry3d& second_pose, double noise, unsigned seed = 1,
             Size size = {240, 180}) {
  const MeshTree tree(object);
  std::vector<View> views{view_at(tree, first_pose, noise, 2 * seed, "first", size),
                          view_at(tree, second_pose, noise, 2 * seed + 1, "second", size)};
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

TEST(PairAlignmentAlignViews, JoinsTwoSidesOfAStatueWithoutAStart) {
  const Pair pair = pair_of(large_statue(), front, other, 0.1);
  expect_right(align_views(pair.first, pair.second), pair);
}

TEST(PairAlignmentAlignViews, JoinsAReliefFromTwoSides) {
  const Pair pair = pair_of(relief(), front, before_camera(turned({0, 1, 0.4}, 25)), 0.1);
  expect_right(align_views(pair.first, pair.second), pair);
}

class PairAlignmentSliding : public testing::TestWithParam<Mesh (*)()> {};

TEST_P(PairAlignmentSliding, IsRefused) {
  const Pair pair = pair_of(GetParam()(), front, before_camera(turned({1, 0.4, 0}, 15)), 0.1);
  const PairAlignment found = align_views(pair.first, pair.second);
  EXPECT_EQ(found.refusal, Refusal::slides) << found.reason;

  // Also from the true pose.
  EXPECT_EQ(refine_alignment(pair.first, pair.second, pair.truth).refusal, Refusal::slides);
}

INSTANTIATE_TEST_SUITE_P(Shapes, PairAlignmentSliding,
                         testing::Values([] { return plate([](double, double) { return 0.0; }); },
                                         ball, pipe));

TEST(PairAlignmentAlignViews, RefusesAPartThatRepeatsItself) {
  const Pair pair = pair_of(ring_of_cones(4), front, before_camera(turned({0, 1, 0}, 15)), 0.1);
  const PairAlignment found = align_views(pair.first, pair.second);
  EXPECT_EQ(found.refusal, Refusal::repeats) << found.reason;
}

// So few points leave its motion open, too; either reason is right.
TEST(PairAlignmentAlignViews, RefusesARepeatedPartOfFewPoints) {
  const Pair pair =
      pair_of(ring_of_cones(4), front, before_camera(turned({0, 1, 0}, 15)), 0.1, 1, {90, 68});
  ASSERT_LT(pair.first.view().size(), 2000U);
  const PairAlignment found = align_views(pair.first, pair.second);
  EXPECT_TRUE(found.refusal == Refusal::repeats || found.refusal == Refusal::slides)
      << found.reason;
}

TEST(PairAlignmentAlignViews, RefusesViewsOfDifferentObjects) {
  std::vector<View> views{view_at(MeshTree(large_statue()), front, 0.1, 1),
                          view_at(MeshTree(relief()), front, 0.1, 2)};
  const float cell = keypoint_cell(views);
  const PreparedView first(std::move(views[0]), cell), second(std::move(views[1]), cell);
  const PairAlignment found = align_views(first, second);
  EXPECT_FALSE(found.joined());
  EXPECT_FALSE(found.reason.empty());
}

TEST(PairAlignmentRefineAlignment, FindsThePoseFromFifteenDegreesOff) {
  const Pair pair = pair_of(relief(), front, before_camera(turned({0, 1, 0.4}, 12)), 0.05);
  const Eigen::Isometry3d start = pair.truth * Eigen::Translation3d(pair.second.middle()) *
                                  turned({0, 0, 1}, 3) *
                                  Eigen::Translation3d(-pair.second.middle());
  expect_right(refine_alignment(pair.first, pair.second, start), pair);
}

TEST(PairAlignmentRefineAlignment, ExpectsTheDistancesThatTheNoiseMakes) {
  const Pair pair = pair_of(relief(), front, other, 0.1);
  const PairAlignment found = alignment_at(pair.first, pair.second, pair.truth);
  EXPECT_NEAR(found.median / found.noise, 1, 0.1);

  // The 95th percentile and the median of the size of a normal deviate: 1.960 and 0.6745.
  EXPECT_NEAR(found.percentile_95 / found.median, 1.960 / 0.6745, 0.3);
}

TEST(PairAlignmentRoughOverlapAt, AllowsForPosesThatAreOffByTwoCells) {
  const Pair pair = pair_of(relief(), front, before_camera(turned({0, 1, 0.4}, 12)), 0.05);
  const double cell = pair.first.keypoints().cell;
  const Eigen::Isometry3d off = pair.truth * Eigen::Translation3d(0, 0, 2 * cell);
  EXPECT_LT(overlap_at(pair.first, pair.second, off), 0.15);
  EXPECT_GT(rough_overlap_at(pair.first, pair.second, off), 0.3);
}

/// Ten pairs of each of four scenes, of overlaps down to a half, by their noise, mm.
class PairAlignmentTable : public testing::TestWithParam<double> {};

TEST_P(PairAlignmentTable, HasNoWrongPose) {
  const std::vector<std::pair<std::string, Mesh>> scenes{{"statue", large_statue()},
                                                         {"boxes", boxes()},
                                                         {"relief", relief()},
                                                         {"engine part", engine_part()}};
  int joined = 0, pairs = 0;
  for (const auto& [name, mesh] : scenes) {
    const int before = joined;
    double least_overlap = 1;
    for (int k = 0; k < 10; ++k) {
      SCOPED_TRACE(name + " " + std::to_string(k));
      const Eigen::Isometry3d turn = turned({0.1 * (k % 4), 1, 0.2}, 15 + 5 * k);
      // From half the distance, ever farther to the sides, so that less is in both views.
      const auto aside = [&](double x) { return Eigen::Translation3d(x * k, 0, -300); };
      const Pair pair = pair_of(mesh, aside(-9) * front, aside(9) * before_camera(turn), GetParam(),
                                static_cast<unsigned>(k + 1));
      const PairAlignment found = align_views(pair.first, pair.second);
      least_overlap = std::min(least_overlap, overlap_at(pair.first, pair.second, pair.truth));
      ++pairs;
      if (!found.joined()) continue;
      ++joined;
      expect_right(found, pair);
    }
    std::printf("%s, %.2f mm: %d of 10 joined, overlap down to %.2f\n", name.c_str(), GetParam(),
                joined - before, least_overlap);
  }

  // Most of the repeated bores are refused, and boxes of whose sides few points are seen.
  EXPECT_GE(joined, GetParam() > 0.2 ? pairs / 3 : pairs / 2);
}

INSTANTIATE_TEST_SUITE_P(Noises, PairAlignmentTable, testing::Values(0.02, 0.1, 0.3));

/// How far pairs are off, by the number of pairs of each object and noise.
class PairAlignmentSigma : public testing::TestWithParam<int> {};

TEST_P(PairAlignmentSigma, IsThatOfTheErrors) {
  Squares errors;
  for (const Mesh& mesh : {large_statue(), relief()}) {
    for (const double noise : {0.05, 0.2}) {
      for (int k = 0; k < GetParam(); ++k) {
        const Eigen::Isometry3d turn = turned({0.1 * k, 1, 0.2}, 15 + 3 * k);
        const Pair pair =
            pair_of(mesh, front, before_camera(turn), noise, static_cast<unsigned>(k + 1));
        const PairAlignment found = refine_alignment(pair.first, pair.second, pair.truth);

        const Eigen::Isometry3d off = pair.truth * found.pose.inverse();
        const Eigen::AngleAxisd by(off.linear());
        Vector6 error;
        error << by.angle() * by.axis(), off * found.centre - found.centre;
        errors.add(error.dot(found.information * error) / 6);
      }
    }
  }
  EXPECT_GT(errors.rms(), 0.7);
  EXPECT_LT(errors.rms(), 1.4);
}

INSTANTIATE_TEST_SUITE_P(Day, PairAlignmentSigma, testing::Values(1));
INSTANTIATE_TEST_SUITE_P(Night, PairAlignmentSigma, testing::Values(6));

TEST(PairAlignmentAlignViews, FindsTheTurnOfARealTurntable) {
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

  // Both clouds have a noise of 0.15 mm.
  EXPECT_LT(found.rms, 0.22);

  // Without points at edges, which are farther than 0.5 mm from the nearest one.
  Squares near;
  for (const Eigen::Vector3f& point : second.view().points) {
    const Eigen::Vector3f place = found.pose.cast<float>() * point;
    const auto nearest = first.grid().nearest(place, 0.5F);
    if (!nearest) continue;
    const Eigen::Vector3f apart = first.view().points[*nearest] - place;
    near.add(std::pow(first.view().normals[*nearest].dot(apart), 2));
  }
  EXPECT_LT(near.rms(), 0.18);

  // The same from starts about the axis, which is about upright through the middle.
  for (const double off : {-15, 15}) {
    SCOPED_TRACE(off);
    const Eigen::AngleAxisd axis(found.pose.linear());
    const Eigen::Isometry3d start = found.pose * Eigen::Translation3d(second.middle()) *
                                    turned(axis.axis(), off) *
                                    Eigen::Translation3d(-second.middle());
    const PairAlignment again = refine_alignment(first, second, start);
    EXPECT_TRUE(again.joined()) << again.reason;
    EXPECT_LT(degrees_off(again.pose, found.pose), 0.005);
  }
}

}  // namespace slipstream::pair_alignment_test
