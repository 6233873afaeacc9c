#include "cloud/plane_frame.h"

#include <array>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "base/numbers.h"
#include "geometry/rotation.h"
#include "slipstream/error.h"

namespace slipstream::plane_frame_test {

/// The faces z = 0, y = 0 and x = 0 of a part that stands at this pose before the camera, seen at
/// places off its corner.
std::array<FittedPlane, 3> faces_at(const Eigen::Isometry3d& part) {
  std::array<FittedPlane, 3> faces;
  const std::array<Eigen::Vector3d, 3> middles{{{30, 20, 0}, {30, 0, 20}, {0, 30, 20}}};
  for (int i = 0; i < 3; ++i) {
    faces[i].normal = part.linear().col(2 - i);
    faces[i].centre = part * middles[i];
  }
  return faces;
}

RC_GTEST_PROP(PlaneFrame, FindsThePoseOfACorner, ()) {
  const auto any = [] { return *rc::gen::inRange(-1000, 1001) * 1e-3; };
  const Eigen::Vector3d turn(any(), any(), any());
  const Eigen::Isometry3d part = pose_from(rotation_of_vector(3 * turn), {20, -30, 600});

  const PlaneFrame found = frame_of_planes(faces_at(part));
  const Eigen::Matrix4d off = (found.pose * part).matrix() - Eigen::Matrix4d::Identity();
  RC_ASSERT(off.cwiseAbs().maxCoeff() < 1e-9);
  for (const double angle : found.off_square) RC_ASSERT(std::abs(angle) < 1e-6);
}

TEST(PlaneFrame, FirstPlaneSetsZAndSaysHowOblique) {
  std::array<FittedPlane, 3> faces = faces_at(pose_from(Eigen::Matrix3d::Identity(), {0, 0, 600}));
  faces[1].normal = rotation_of_vector({2 * degree, 0, 0}) * faces[1].normal;

  const PlaneFrame found = frame_of_planes(faces);
  EXPECT_LT((found.pose.linear() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(found.off_square[0] / degree, 2, 1e-9);
  EXPECT_NEAR(found.off_square[1] / degree, 0, 1e-9);
}

TEST(PlaneFrame, SaysInWhichDirectionTheAngleIsOff) {
  std::array<FittedPlane, 3> faces = faces_at(pose_from(Eigen::Matrix3d::Identity(), {0, 0, 600}));
  faces[1].normal = rotation_of_vector({-2 * degree, 0, 0}) * faces[1].normal;
  EXPECT_NEAR(frame_of_planes(faces).off_square[0] / degree, -2, 1e-9);
}

TEST(PlaneFrame, RefusesPlanesThatDoNotMeetInAPoint) {
  const Eigen::Isometry3d part = pose_from(Eigen::Matrix3d::Identity(), {0, 0, 600});
  std::array<FittedPlane, 3> faces = faces_at(part);
  faces[2].normal = faces[0].normal;
  EXPECT_THROW(frame_of_planes(faces), Error);

  // A prism's faces share a direction.
  faces = faces_at(part);
  faces[2].normal = Eigen::Vector3d(0, 1, 1).normalized();
  EXPECT_THROW(frame_of_planes(faces), Error);
}

}  // namespace slipstream::plane_frame_test
