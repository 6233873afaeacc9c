#include "geometry/rotation.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "base/numbers.h"
#include "slipstream/error.h"

namespace slipstream::rotation_test {

/// The 12 orders of axes, intrinsic and extrinsic.
std::vector<EulerOrder> all_orders() {
  std::vector<EulerOrder> orders;
  for (const std::string kind : {"intrinsic ", "extrinsic "}) {
    for (const char* axes :
         {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"}) {
      orders.push_back(euler_order_named(kind + axes));
    }
  }
  return orders;
}

/// A multiple of a sixteenth of a right angle: also rotations in which notations are singular.
double any_angle() {
  return *rc::gen::inRange(-64, 65) * std::numbers::pi / 32;
}

Eigen::Matrix3d any_rotation() {
  const double roll = any_angle(), pitch = any_angle(), yaw = any_angle();
  return rotation_of_euler({roll, pitch, yaw}, {});
}

/// The message of an Error, or nothing.
template <class Call>
std::string message_of(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

RC_GTEST_PROP(Rotation, EveryNotationReturnsTheSameRotation, ()) {
  const Eigen::Matrix3d rotation = any_rotation();
  const auto require_equal = [&](const Eigen::Matrix3d& again) {
    RC_ASSERT((again - rotation).cwiseAbs().maxCoeff() < 1e-12);
  };

  for (const EulerOrder& order : all_orders()) {
    require_equal(rotation_of_euler(euler_of(rotation, order), order));
  }
  for (const QuaternionOrder order : {QuaternionOrder::xyzw, QuaternionOrder::wxyz}) {
    require_equal(rotation_of_quaternion(quaternion_of(rotation, order), order));
  }
  require_equal(rotation_of_vector(vector_of(rotation)));
  require_equal(checked_rotation(rotation));
}

TEST(Rotation, MiddleEulerAngleOfHalfATurnIsPositive) {
  const Eigen::Vector3d turns(-180 * degree, -360 * degree, -360 * degree);
  const Eigen::Matrix3d rotation = rotation_of_euler(turns, {});
  for (const EulerOrder& order : all_orders()) EXPECT_GT(euler_of(rotation, order)[1], -1e-12);
}

RC_GTEST_PROP(Rotation, MiddleEulerAngleStaysInItsRange, ()) {
  const Eigen::Matrix3d rotation = any_rotation();
  for (const EulerOrder& order : all_orders()) {
    const double middle = euler_of(rotation, order)[1];
    if (order.axes[0] == order.axes[2]) {
      RC_ASSERT(middle > -1e-12 && middle < std::numbers::pi + 1e-12);
    } else {
      RC_ASSERT(std::abs(middle) < std::numbers::pi / 2 + 1e-12);
    }
  }
}

TEST(Rotation, EulerOrdersTurnAsTheirNamesSay) {
  // 90 degrees about x take y to z; then 90 about the fixed z leave it, about the turned z (now -y)
  // take it to x.
  const Eigen::Vector3d angles(90 * degree, 0, 90 * degree);
  const Eigen::Vector3d fixed =
      rotation_of_euler(angles, euler_order_named("extrinsic xyz")) * Eigen::Vector3d::UnitY();
  EXPECT_LT((fixed - Eigen::Vector3d::UnitZ()).norm(), 1e-12);

  const Eigen::Vector3d turned =
      rotation_of_euler(angles, euler_order_named("intrinsic xyz")) * Eigen::Vector3d::UnitY();
  EXPECT_LT((turned + Eigen::Vector3d::UnitX()).norm(), 1e-12);
}

TEST(Rotation, QuaternionOrdersNameTheRealPart) {
  const double half = std::sqrt(0.5);
  const Eigen::Matrix3d about_z = rotation_of_vector({0, 0, 90 * degree});
  EXPECT_LT((rotation_of_quaternion({0, 0, half, half}, QuaternionOrder::xyzw) - about_z).norm(),
            1e-12);
  EXPECT_LT((rotation_of_quaternion({half, 0, 0, half}, QuaternionOrder::wxyz) - about_z).norm(),
            1e-12);
}

TEST(Rotation, RoundedMatrixBecomesARotation) {
  Eigen::Matrix3d rounded = rotation_of_vector({0.3, -0.5, 0.2});
  rounded = (rounded * 1e4).array().round() / 1e4;
  const Eigen::Matrix3d rotation = checked_rotation(rounded);
  EXPECT_LT((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_LT((rotation - rounded).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_THROW(checked_rotation(1.01 * rotation), Error);

  // Where the nearest orthogonal matrix mirrors, the weakest axis turns around.
  const Eigen::Matrix3d mirrored = Eigen::Vector3d(1, 0.9, -0.1).asDiagonal().toDenseMatrix();
  EXPECT_LT((nearest_rotation(rotation * mirrored) - rotation).norm(), 1e-12);
}

TEST(Rotation, RefusesWhatIsNoneAndSaysHowFarOff) {
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  EXPECT_NE(message_of([&] { checked_rotation(1.1 * one); }).find("off by 0.21,"),
            std::string::npos);

  Eigen::Matrix3d mirror = one;
  mirror(2, 2) = -1;
  EXPECT_NE(message_of([&] { checked_rotation(mirror); }).find("mirrors"), std::string::npos);
  EXPECT_NE(message_of([&] { checked_rotation(nan * one); }).find("not finite"), std::string::npos);

  const auto quaternion = [](double x, double w) {
    rotation_of_quaternion({x, 0, 0, w}, QuaternionOrder::xyzw);
  };
  EXPECT_NE(message_of([&] { quaternion(0.6, 0.7); }).find("norm is 0.921954"), std::string::npos);
  EXPECT_THROW(quaternion(nan, 1), Error);
  EXPECT_THROW(rotation_of_vector({nan, 0, 0}), Error);
  EXPECT_THROW(rotation_of_vector({1e200, 0, 0}), Error);
  EXPECT_THROW(rotation_of_euler({0, nan, 0}, {}), Error);
}

TEST(Rotation, RefusesATransposedPose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(0, 3) = 100;
  EXPECT_EQ(pose_of_matrix(matrix).translation(), Eigen::Vector3d(100, 0, 0));
  EXPECT_NE(message_of([&] { pose_of_matrix(matrix.transpose()); }).find("transposed"),
            std::string::npos);
}

TEST(Rotation, RefusesOrdersThatCouldMeanTwo) {
  for (const char* text : {"xyz", "zyx", "", "intrinsic", "intrinsic xxy", "intrinsic zyx ",
                           "extrinsic xya", "Intrinsic xyz", "static xyz"}) {
    EXPECT_THROW(euler_order_named(text), Error) << text;
  }
  for (const EulerOrder& order : all_orders()) EXPECT_EQ(euler_order_named(name_of(order)), order);

  EXPECT_THROW(quaternion_order_named("wxy"), Error);
  EXPECT_EQ(quaternion_order_named("wxyz"), QuaternionOrder::wxyz);
}

}  // namespace slipstream::rotation_test
