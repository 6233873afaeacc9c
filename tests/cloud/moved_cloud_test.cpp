#include <cmath>
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "base/numbers.h"
#include "geometry/rotation.h"
#include "slipstream/cleaner.h"
#include "slipstream/cloud.h"
#include "slipstream/error.h"
#include "slipstream/surface.h"
#include "tests/io/sheet_cloud.h"

namespace slipstream::moved_cloud_test {

/// The pose of the camera in a robot's base.
FramePose base_pose() {
  return {"camera", "robot_base",
          pose_from(rotation_of_euler({170 * degree, -20 * degree, 35 * degree}, {}),
                    {900, -250, 1400})};
}

FramePose any_pose(const std::string& from, const std::string& to) {
  const auto any = [] { return *rc::gen::inRange(-1000, 1001) * 1e-3; };
  const Eigen::Vector3d turn(any(), any(), any()), shift(any(), any(), any());
  return {from, to, pose_from(rotation_of_vector(3 * turn), 1500 * shift)};
}

double largest_difference(const Cloud& a, const Cloud& b) {
  double largest = 0;
  for_each_pixel_in_order(a.size(), [&](int column, int row) {
    if (a.validity(column, row) != Validity::valid) return;
    const Eigen::Vector3d apart = position_at(a, column, row) - position_at(b, column, row);
    largest = std::max(largest, apart.norm());
  });
  return largest;
}

RC_GTEST_PROP(MovedCloud, ReturnsToTheCamera, ()) {
  const Cloud given = sheet_cloud();
  Cloud cloud = given;
  move_to_frame(cloud, any_pose("camera", "flange"));
  move_to_frame(cloud, any_pose("base", "flange"));
  RC_ASSERT(frame_name(cloud) == "base");

  move_to_camera(cloud);
  RC_ASSERT(frame_name(cloud) == camera_frame);
  RC_ASSERT(largest_difference(given, cloud) < 2e-3);
}

RC_GTEST_PROP(MovedCloud, PosesComposeAndInvert, ()) {
  const FramePose to_flange = any_pose("camera", "flange"), to_base = any_pose("flange", "base");
  const FramePose whole = compose(to_flange, to_base);
  RC_ASSERT(whole.from == "camera" && whole.to == "base");

  const Eigen::Matrix4d back =
      compose(whole, inverse(to_base)).transform.matrix() - to_flange.transform.matrix();
  RC_ASSERT(back.cwiseAbs().maxCoeff() < 1e-9);
}

TEST(MovedCloud, EachPointAndNormalIsMappedAndPixelsStay) {
  const Cloud given = sheet_cloud();
  const FramePose pose = base_pose();
  Cloud cloud = given;
  Normals normals = surface_normals(given);
  const Normals before = normals;
  move_to_frame(cloud, pose);
  move_to_frame(normals, pose);

  EXPECT_EQ(cloud.size(), given.size());
  for_each_pixel_in_order(given.size(), [&](int column, int row) {
    EXPECT_EQ(cloud.validity(column, row), given.validity(column, row));
    if (given.validity(column, row) != Validity::valid) {
      EXPECT_TRUE(std::isnan(cloud.x(column, row)));
      return;
    }

    const Eigen::Vector3d expected = pose.transform * position_at(given, column, row);
    EXPECT_LT((position_at(cloud, column, row) - expected).norm(), 1e-3);
    if (std::isnan(before.x(column, row))) return;
    const Eigen::Vector3d old(before.x(column, row), before.y(column, row), before.z(column, row));
    const Eigen::Vector3d turned(normals.x(column, row), normals.y(column, row),
                                 normals.z(column, row));
    EXPECT_LT((turned - pose.transform.linear() * old).norm(), 1e-5);
  });
}

TEST(MovedCloud, SigmaStaysAlongTheRay) {
  Cloud cloud({1, 1});
  cloud.x(0, 0) = 300;
  cloud.y(0, 0) = 0;
  cloud.z(0, 0) = 400;
  cloud.validity(0, 0) = Validity::valid;
  Uncertainty sigma({1, 1});
  sigma.x(0, 0) = 0.03F;
  sigma.y(0, 0) = 0;
  sigma.z(0, 0) = 0.04F;
  sigma.coordinate(0, 0) = 1e-5F;

  // A turn about the camera's y that puts the ray along the new z.
  const Eigen::Matrix3d turn = rotation_of_vector({0, -std::atan2(300, 400), 0});
  move_to_frame(cloud, {"camera", "table", pose_from(turn, {50, 60, 70})}, &sigma);
  EXPECT_NEAR(cloud.z(0, 0), 570, 1e-3);
  EXPECT_NEAR(sigma.x(0, 0), 0, 1e-6);
  EXPECT_NEAR(sigma.z(0, 0), 0.05, 1e-6);
  EXPECT_FLOAT_EQ(sigma.coordinate(0, 0), 1e-5F);
}

TEST(MovedCloud, ThinnedAndConvertedCloudsKeepTheirFrame) {
  Cloud cloud = sheet_cloud();
  move_to_frame(cloud, base_pose());
  EXPECT_EQ(frame_name(subsampled(cloud, 2)), "robot_base");

  BasicCloud<double> exact;
  convert(cloud, exact);
  EXPECT_EQ(frame_name(exact), "robot_base");
}

TEST(MovedCloud, RefusesAPoseOfOtherFrames) {
  Cloud cloud = sheet_cloud();
  EXPECT_THROW(move_to_frame(cloud, FramePose{"flange", "base"}), Error);
  move_to_frame(cloud, inverse(base_pose()));  // the names tell the direction
  EXPECT_EQ(frame_name(cloud), "robot_base");
  EXPECT_THROW(compose(base_pose(), base_pose()), Error);
}

TEST(MovedCloud, WhatNeedsTheCamerasRaysRefusesIt) {
  Cloud cloud = sheet_cloud();
  move_to_frame(cloud, base_pose());
  EXPECT_THROW(surface_of(cloud), Error);
  EXPECT_THROW(surface_normals(cloud), Error);
  EXPECT_THROW(smoothed_normals(cloud), Error);
  Cleaner clean;
  EXPECT_THROW(clean(cloud), Error);
}

TEST(MovedCloud, FrameNamesAreThoseThatAllFilesTake) {
  for (const char* name : {"base", "robot_1/tool0", "a.b-c"}) require_frame_name(name);
  for (const std::string name : {std::string(), std::string("robot base"), std::string("a\nb"),
                                 std::string(49, 'a'), std::string("b\xc3\xa4")}) {
    EXPECT_THROW(require_frame_name(name), Error) << name;
  }
}

TEST(MovedCloud, BoxIsAlongTheAxesOfItsFrame) {
  CleanSettings settings = CleanSettings::none();
  settings.box = PointBox{{-20, -20, -5}, {20, 20, 5}};
  // A frame in the middle of the sheet whose z looks back at the camera.
  const Eigen::Matrix3d turn = rotation_of_euler({40 * degree, 0, 180 * degree}, {});
  settings.box_frame = std::make_shared<const FramePose>(
      FramePose{"camera", "table", pose_from(turn, -turn * Eigen::Vector3d(0, 0, 600))});

  const Cloud given = sheet_cloud();
  Cloud cloud = given;
  Cleaner clean(settings);
  clean(cloud);

  std::size_t kept = 0;
  for_each_pixel_in_order(given.size(), [&](int column, int row) {
    if (given.validity(column, row) != Validity::valid) return;
    const Eigen::Vector3d place = settings.box_frame->transform * position_at(given, column, row);
    const bool inside =
        std::abs(place.x()) < 20 && std::abs(place.y()) < 20 && std::abs(place.z()) < 5;
    EXPECT_EQ(cloud.validity(column, row) == Validity::valid, inside);
    if (inside) ++kept;
  });
  EXPECT_GT(kept, 3U);

  // The pose may be given in either direction, but must have the camera's frame.
  settings.box_frame = std::make_shared<const FramePose>(inverse(*settings.box_frame));
  Cloud other = given;
  Cleaner inverted(settings);
  inverted(other);
  EXPECT_EQ(point_count(other), kept);

  settings.box_frame = std::make_shared<const FramePose>(FramePose{"flange", "base"});
  EXPECT_THROW(Cleaner{settings}, Error);
}

}  // namespace slipstream::moved_cloud_test
