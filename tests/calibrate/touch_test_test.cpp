#include "calibrate/touch_test.h"

#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "calibrate/virtual_robot.h"
#include "geometry/rotation.h"
#include "slipstream/error.h"

namespace slipstream::touch_test_test {

const Eigen::Vector3d tip(5, -3, 150);

/// Nine points of a board, and the tool with its tip on each.
struct Touched {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Isometry3d> tools;
  Eigen::Isometry3d camera;
};

Touched touched(EyePlace place) {
  const RobotRun run = moved_robot(
      {.place = place, .poses = 9, .rotation_error = 0, .translation_error = 0, .pixel_error = 0});
  Touched all;
  all.camera = run.truth.camera;
  if (place == EyePlace::in_hand) all.camera = run.pairs[0].robot * all.camera;

  for (std::size_t i = 0; i < run.pairs.size(); ++i) {
    all.points.emplace_back(-60 + 15.0 * static_cast<double>(i), 20.0 * static_cast<double>(i % 3),
                            500);
    const Eigen::Matrix3d turn = run.pairs[i].robot.linear();
    all.tools.push_back(pose_from(turn, all.camera * all.points[i] - turn * tip));
  }
  return all;
}

TEST(TouchTest, FindsAnErrorOfHalfAMillimetreWithItsSign) {
  for (const EyePlace place : {EyePlace::in_hand, EyePlace::to_hand}) {
    const Touched all = touched(place);
    for (int axis = 0; axis < 3; ++axis) {
      for (const double error : {-0.5, 0.5}) {
        Eigen::Isometry3d camera = all.camera;
        camera.translation()[axis] += error;
        const TouchTest test = touch_test(all.points, camera, all.tools, tip);
        EXPECT_LT((test.mean - error * Eigen::Vector3d::Unit(axis)).norm(), 1e-6);

        const Verdict verdict = verdict_of(test, 0.3);
        EXPECT_STREQ(verdict.grade, "bad");
        const std::string expected =
            std::string(error > 0 ? "+0.500" : "-0.500") + " mm in " + "xyz"[axis];
        EXPECT_NE(verdict.words.find(expected), std::string::npos) << verdict.words;
      }
    }
  }
}

TEST(TouchTest, AnExactPoseIsGood) {
  const Touched all = touched(EyePlace::in_hand);
  const TouchTest test = touch_test(all.points, all.camera, all.tools, tip);
  EXPECT_LT(test.largest, 1e-6);
  EXPECT_STREQ(verdict_of(test, 0.3).grade, "good");
}

TEST(TouchTest, OnePointOffIsNoErrorOfTheCalibration) {
  Touched all = touched(EyePlace::in_hand);
  all.tools[4].translation().x() -= 1.5;
  const TouchTest test = touch_test(all.points, all.camera, all.tools, tip);
  EXPECT_STREQ(verdict_of(test, 0.3).grade, "usable");
  EXPECT_NEAR(test.differences[4].x(), 1.5, 1e-6);
  EXPECT_NEAR(test.standard_error.x(), 1.5 / 9, 1e-6);  // as one of nine is off
}

TEST(TouchTest, AMeanWithinTwoErrorsOfTheToleranceIsNotBad) {
  const TouchTest test{.mean = {0.4, 0, 0}, .standard_error = {0.1, 0, 0}, .largest = 0.8};
  EXPECT_STREQ(verdict_of(test, 0.3).grade, "usable");
  EXPECT_STREQ(verdict_of(test, 0.15).grade, "bad");
}

TEST(TouchTest, NeedsATouchForEachPoint) {
  Touched all = touched(EyePlace::in_hand);
  all.tools.pop_back();
  EXPECT_THROW(touch_test(all.points, all.camera, all.tools, tip), Error);
  EXPECT_THROW(touch_test({}, all.camera, {}, tip), Error);
}

}  // namespace slipstream::touch_test_test
