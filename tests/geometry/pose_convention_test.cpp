#include "geometry/pose_convention.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/error.h"

namespace slipstream::pose_convention_test {

const Eigen::Isometry3d some_pose =
    pose_from(rotation_of_vector({0.3, -0.5, 0.8}), {100, -20, 300});

TEST(PoseConvention, WritesWhatItReads) {
  for (const std::size_t numbers : {6U, 7U, 16U}) {
    for (const RotationNotation& notation : notations_of(numbers)) {
      const std::vector<double> row = row_of(some_pose, notation);
      ASSERT_EQ(row.size(), numbers);
      EXPECT_TRUE(pose_of(row, notation).isApprox(some_pose, 1e-9)) << name_of(notation);
    }
  }
}

TEST(PoseConvention, ReadsInversePosesInMetres) {
  const RotationNotation notation = *notation_of_robot("abb");
  Eigen::Isometry3d written = some_pose.inverse();
  written.translation() /= 1000;
  const auto read = poses_of(PoseTable{{}, {row_of(written, notation)}},
                             PoseConvention{.rotation = notation, .unit = 1000, .inverse = true});
  EXPECT_TRUE(read[0] && read[0]->isApprox(some_pose, 1e-9));
}

TEST(PoseConvention, ReadsTheSamePoseOfEachRobot) {
  // Rz(90) Rx(90), as the manuals of the makers write it.
  const Eigen::Matrix3d turn = (Eigen::Matrix3d() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished();
  const double third = 2.0943951023931953 / 1.7320508075688772;
  const std::vector<std::pair<std::string, std::vector<double>>> written{
      {"KUKA", {1, 2, 3, 90, 0, 90}},
      {"fanuc", {1, 2, 3, 90, 0, 90}},
      {"Yaskawa", {1, 2, 3, 90, 0, 90}},
      {"doosan", {1, 2, 3, 0, 90, 90}},
      {"kawasaki", {1, 2, 3, 0, 90, 90}},
      {"UR", {1, 2, 3, third, third, third}},
      {"abb", {1, 2, 3, 0.5, 0.5, 0.5, 0.5}},
      {"franka", {0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 2, 3, 1}}};
  for (const auto& [robot, row] : written) {
    const Eigen::Isometry3d pose = pose_of(row, *notation_of_robot(robot));
    EXPECT_TRUE(pose.isApprox(pose_from(turn, {1, 2, 3}), 1e-9)) << robot << "\n" << pose.matrix();
  }
}

TEST(PoseConvention, IsNamedByItsParts) {
  const PoseFrames frames{"tool", "base"};
  const PoseConvention metres{*notation_of_robot("kuka"), 1000, true};
  EXPECT_EQ(name_of(metres, frames), "intrinsic zyx in degrees, m, base to tool");

  EXPECT_EQ(conventions_of(6, frames, "").size(), 200U);
  for (const char* const known :
       {"kuka, m, base to tool", "intrinsic zyx in degrees,m,base to tool"}) {
    const auto conventions = conventions_of(6, frames, known);
    ASSERT_EQ(conventions.size(), 1U);
    EXPECT_EQ(name_of(conventions[0], frames), name_of(metres, frames));
  }
}

TEST(PoseConvention, RefusesPartsThatFitNoNumbers) {
  const PoseFrames frames{"tool", "base"};
  EXPECT_THROW(conventions_of(7, frames, "kuka"), Error);
  EXPECT_THROW(conventions_of(6, frames, "inches"), Error);
  EXPECT_THROW(notations_of(5), Error);
}

TEST(PoseConvention, NumbersThatAreNoPoseGiveNone) {
  const RotationNotation quaternion = *notation_of_robot("abb");
  const PoseTable table{{}, {{1, 2, 3, 1, 0, 0, 0}, {1, 2, 3, 1, 1, 0, 0}}};
  const auto poses = poses_of(table, quaternion);
  EXPECT_TRUE(poses[0]);
  EXPECT_FALSE(poses[1]);
}

}  // namespace slipstream::pose_convention_test
