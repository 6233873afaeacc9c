#include "merge/turntable.h"

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "base/numbers.h"
#include "tests/io/expect_error.h"

namespace slipstream::turntable_test {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double turn_noise = 2e-4, shift_noise = 0.02;  // rad, mm
const Eigen::Vector3d middle(10, 20, 620);

/// A table whose axis leans, in front of the camera.
Turntable tilted_table(const std::vector<double>& angles) {
  Turntable table{.direction = Eigen::Vector3d(0.1, -0.9, -0.3).normalized(),
                  .point = {15, 30, 640},
                  .angles = angles};
  table.point += table.direction.dot(middle - table.point) * table.direction;
  return table;
}

std::vector<double> steps_of(int views, double step) {
  std::vector<double> angles;
  for (int view = 0; view < views; ++view) angles.push_back(view * step);
  return angles;
}

Eigen::Isometry3d motion_of(const Vector6& step, const Eigen::Vector3d& centre) {
  const Eigen::Vector3d turn = step.head<3>();
  return Eigen::Translation3d(centre + step.tail<3>()) *
         Eigen::AngleAxisd(turn.norm(), turn.normalized()) * Eigen::Translation3d(-centre);
}

/// Pairs of views at most `reach` apart on a table, with noise; also across the end of a turn.
std::vector<PairPose> pairs_of(const Turntable& table, std::size_t reach, unsigned seed,
                               double noise = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, noise);
  const std::size_t views = table.angles.size();

  std::vector<PairPose> pairs;
  for (std::size_t view = 0; view < views; ++view) {
    for (std::size_t gap = 1; gap <= reach; ++gap) {
      const std::size_t next = view + gap;
      const bool closes = std::abs(table.angles[1] * static_cast<double>(views) - two_pi) < 0.1;
      if (next >= views && !closes) continue;

      PairPose pair{.first = view, .second = next % views};
      if (pair.second < pair.first) std::swap(pair.first, pair.second);
      Vector6 off;
      for (int i = 0; i < 6; ++i) off[i] = normal(random) * (i < 3 ? turn_noise : shift_noise);
      pair.centre = middle;
      pair.pose = motion_of(off, middle) * pose_on(table, pair.first, pair.second);
      for (int i = 0; i < 6; ++i) {
        pair.information(i, i) = 1 / std::pow(i < 3 ? turn_noise : shift_noise, 2);
      }
      pairs.push_back(pair);
    }
  }
  return pairs;
}

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

TEST(Turntable, AxisAndStepAreFoundWithinTheirSigma) {
  const Turntable truth = tilted_table(steps_of(12, 30 * degree));
  double direction = 0, point = 0, step = 0;
  constexpr int runs = 20;

  for (unsigned seed = 1; seed <= runs; ++seed) {
    const TurntableFit fit = fit_turntable(12, pairs_of(truth, 2, seed));
    ASSERT_TRUE(fit.table.step);
    EXPECT_FALSE(fit.moved);
    direction +=
        std::pow(angle_between(fit.table.direction, truth.direction) / fit.table.direction_sigma,
                 2) /
        (2 * runs);
    point += (fit.table.point - truth.point).squaredNorm() / std::pow(fit.table.point_sigma, 2) /
             (2 * runs);
    step += std::pow((*fit.table.step - 30 * degree) / fit.table.step_sigma, 2) / runs;
    EXPECT_LT(fit.table.direction_sigma, 0.02 * degree);
  }

  // Squares of errors in standard deviations; those are of the least known directions.
  for (const double square : {direction, point, step}) {
    EXPECT_GT(square, 0.3);
    EXPECT_LT(square, 2);
  }
}

TEST(Turntable, AKnownStepIsKept) {
  const Turntable truth = tilted_table(steps_of(5, -20 * degree));
  const TurntableFit fit = fit_turntable(5, pairs_of(truth, 1, 3), {.step = -20 * degree});
  EXPECT_EQ(fit.table.step, -20 * degree);
  EXPECT_LT(angle_between(fit.table.direction, truth.direction), 0.1 * degree);

  // Without it the direction is the one about which the step is positive.
  const TurntableFit found = fit_turntable(5, pairs_of(truth, 1, 3));
  EXPECT_NEAR(*found.table.step, 20 * degree, 0.05 * degree);
  EXPECT_LT(angle_between(found.table.direction, -truth.direction), 0.1 * degree);
}

// The information leaves the whole motion open but the turns.
TEST(Turntable, HasNoSigmaOfWhatTheViewsLeaveOpen) {
  Turntable truth = tilted_table(steps_of(4, 0.3));
  truth.step = 0.3;
  const std::vector<PairPose> pairs = pairs_of(truth, 1, 3);
  const auto of_turns = [&](std::size_t k, const Eigen::Isometry3d&) {
    PairEquations equations{.centre = pairs[k].centre};
    equations.squares.diagonal().head<3>() = pairs[k].information.diagonal().head<3>();
    equations.information = equations.squares;
    return equations;
  };
  EXPECT_TRUE(std::isinf(refined_turntable(truth, pairs, of_turns, 1).point_sigma));
}

TEST(Turntable, StepsMayDiffer) {
  const std::vector<double> angles{0, 0.5, 0.9, 1.7, 2.0};
  const TurntableFit fit = fit_turntable(5, pairs_of(tilted_table(angles), 2, 5));
  EXPECT_FALSE(fit.table.step);
  EXPECT_FALSE(fit.moved);
  for (std::size_t view = 0; view < 5; ++view) {
    EXPECT_NEAR(fit.table.angles[view], angles[view], 0.002);
  }
}

TEST(Turntable, AViewThatWasMovedByHandIsNamed) {
  const Turntable truth = tilted_table(steps_of(12, 30 * degree));
  Vector6 bump;
  bump << 0.02, -0.01, 0.03, 1.5, -0.5, 1;
  const Eigen::Isometry3d moved_by = motion_of(bump, middle);

  for (const bool stays : {true, false}) {
    for (const std::size_t view : {3U, 7U, 11U}) {
      // In the first view's frame all its points, and perhaps those after it, lie elsewhere.
      const auto is_moved = [&](std::size_t at) { return stays ? at >= view : at == view; };
      std::vector<PairPose> pairs = pairs_of(truth, 2, 7);
      for (PairPose& pair : pairs) {
        const auto to_first = [&](std::size_t at) {
          return is_moved(at) ? moved_by * pose_on(truth, 0, at) : pose_on(truth, 0, at);
        };
        const Eigen::Isometry3d noise =
            pair.pose * pose_on(truth, pair.first, pair.second).inverse();
        pair.pose = noise * to_first(pair.first).inverse() * to_first(pair.second);
      }

      const TurntableFit fit = fit_turntable(12, pairs);
      ASSERT_TRUE(fit.moved) << view;
      EXPECT_EQ(fit.moved->view, view);
      if (view < 11) {
        EXPECT_EQ(fit.moved->stays, stays) << view;
      }
      EXPECT_NEAR(fit.moved->turn, bump.head<3>().norm(), 0.002);
      EXPECT_LT(angle_between(fit.table.direction, truth.direction), 0.02 * degree);

      const Eigen::Isometry3d pose = moved_by * pose_on(truth, 0, view);
      EXPECT_LT((fit.poses[view] * middle - pose * middle).norm(), 0.2);
    }
  }
}

TEST(Turntable, AWrongPairDoesNotCount) {
  const Turntable truth = tilted_table(steps_of(12, 30 * degree));
  std::vector<PairPose> pairs = pairs_of(truth, 2, 9);
  pairs[4].pose = Eigen::Isometry3d(Eigen::AngleAxisd(1.9, Eigen::Vector3d::UnitX()));
  const TurntableFit fit = fit_turntable(12, pairs);
  EXPECT_LT(angle_between(fit.table.direction, truth.direction), 0.02 * degree);
  EXPECT_FALSE(fit.agrees[4]);
}

TEST(Turntable, IsRefusedWithoutAnAxis) {
  expect_error([] { (void)fit_turntable(2, {}); }, {"needs three views"});

  const Turntable still = tilted_table(steps_of(6, 1e-4));
  expect_error([&] { (void)fit_turntable(6, pairs_of(still, 1, 1, 0.01)); }, {"hardly turn"});

  // Views from all sides, and views that no pair joins.
  std::vector<PairPose> pairs = pairs_of(tilted_table(steps_of(6, 0.5)), 1, 1);
  pairs.pop_back();
  for (PairPose& pair : pairs) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Random().normalized();
    pair.pose = Eigen::Isometry3d(Eigen::AngleAxisd(0.5, axis));
  }
  expect_error([&] { (void)fit_turntable(6, pairs); }, {"about one axis"});
}

}  // namespace slipstream::turntable_test
