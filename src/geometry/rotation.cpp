#include "geometry/rotation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include <Eigen/SVD>

#include "base/numbers.h"
#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

constexpr std::string_view axis_letters = "xyz";

/// Turn about one of the three axes.
Eigen::Matrix3d turn_about(int axis, double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)).toRotationMatrix();
}

/// 1 if the axes i, j, k are right-handed in this order, -1 if left-handed.
double handedness(int i, int j) {
  return (i + 1) % 3 == j ? 1 : -1;
}

/// Three turns in the order in which their matrices are multiplied.
struct IntrinsicTurns {
  std::array<int, 3> axes{};
  Eigen::Vector3d angles;
};

/// Extrinsic turns are the intrinsic ones in reverse.
IntrinsicTurns intrinsic_turns(const Eigen::Vector3d& angles, const EulerOrder& order) {
  IntrinsicTurns turns{order.axes, angles};
  if (!order.intrinsic) {
    std::reverse(turns.axes.begin(), turns.axes.end());
    turns.angles.reverseInPlace();
  }
  return turns;
}

void require_finite(bool finite, std::string_view what) {
  throw_if(!finite, "{} has a number that is not finite", what);
}

}  // namespace

EulerOrder euler_order_named(std::string_view text) {
  const std::size_t space = std::min(text.find(' '), text.size());
  const std::string_view kind = text.substr(0, space);
  const std::string_view letters = text.substr(std::min(space + 1, text.size()));

  EulerOrder order{.intrinsic = kind == "intrinsic"};
  bool valid = (order.intrinsic || kind == "extrinsic") && letters.size() == 3;

  for (std::size_t i = 0; valid && i < 3; ++i) {
    const std::size_t axis = axis_letters.find(letters[i]);
    valid = axis != axis_letters.npos;
    order.axes[i] = static_cast<int>(axis);
  }

  valid = valid && order.axes[1] != order.axes[0] && order.axes[1] != order.axes[2];
  throw_if(!valid,
           "'{}' is not an order of Euler angles; write whether the axes turn with the frame, and "
           "their order, e.g. 'intrinsic zyx' or 'extrinsic xyz'",
           text.substr(0, 40));
  return order;
}

std::string name_of(const EulerOrder& order) {
  std::string name = order.intrinsic ? "intrinsic " : "extrinsic ";
  for (const int axis : order.axes) name += axis_letters[static_cast<std::size_t>(axis)];
  return name;
}

QuaternionOrder quaternion_order_named(std::string_view text) {
  if (text == "xyzw") return QuaternionOrder::xyzw;
  if (text == "wxyz") return QuaternionOrder::wxyz;
  throw Error(fmt::format("'{}' is not an order of a quaternion's numbers; use xyzw or wxyz",
                          text.substr(0, 40)));
}

std::string_view name_of(QuaternionOrder order) {
  return order == QuaternionOrder::xyzw ? "xyzw" : "wxyz";
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);

  // The nearest orthogonal matrix may mirror: then the weakest axis turns around.
  Eigen::Vector3d signs(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) signs.z() = -1;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

Eigen::Matrix3d checked_rotation(const Eigen::Matrix3d& matrix) {
  require_finite(matrix.allFinite(), "the rotation matrix");

  const Eigen::Matrix3d product = matrix.transpose() * matrix;
  const double off = (product - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  throw_if(off > rotation_tolerance,
           "the matrix is not a rotation: the products of its columns are off by {:.3g}, at most "
           "{:g} is rounding",
           off, rotation_tolerance);
  throw_if(matrix.determinant() < 0,
           "the matrix mirrors: its determinant is -1, that of a rotation is 1; one axis points "
           "the wrong way, or two are swapped");

  // A matrix that is as near to a rotation as doubles allow stays as it is.
  constexpr double rounding = 1e-14;
  if (off <= rounding) return matrix;
  return nearest_rotation(matrix);
}

Eigen::Matrix3d rotation_of_quaternion(const Eigen::Vector4d& numbers, QuaternionOrder order) {
  require_finite(numbers.allFinite(), "the quaternion");

  const double norm = numbers.norm();
  throw_if(std::abs(norm - 1) > rotation_tolerance,
           "the quaternion is not a rotation: its norm is {:.6g}, that of a rotation is 1", norm);

  // Eigen stores x, y, z, w.
  Eigen::Vector4d stored = numbers;
  if (order == QuaternionOrder::wxyz) stored << numbers.tail<3>(), numbers[0];
  return Eigen::Quaterniond(stored).normalized().toRotationMatrix();
}

Eigen::Vector4d quaternion_of(const Eigen::Matrix3d& rotation, QuaternionOrder order) {
  Eigen::Vector4d stored = Eigen::Quaterniond(rotation).normalized().coeffs();
  if (stored[3] < 0) stored = -stored;

  if (order == QuaternionOrder::xyzw) return stored;
  return {stored[3], stored[0], stored[1], stored[2]};
}

Eigen::Matrix3d rotation_of_vector(const Eigen::Vector3d& vector) {
  require_finite(vector.allFinite(), "the rotation vector");

  const double angle = vector.norm();
  throw_if(!std::isfinite(angle), "the rotation vector is too long: {:g}, {:g}, {:g}", vector.x(),
           vector.y(), vector.z());
  if (angle == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

Eigen::Vector3d vector_of(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

Eigen::Matrix3d rotation_of_euler(const Eigen::Vector3d& angles, const EulerOrder& order) {
  require_finite(angles.allFinite(), "the list of Euler angles");

  const IntrinsicTurns turns = intrinsic_turns(angles, order);
  return turn_about(turns.axes[0], turns.angles[0]) * turn_about(turns.axes[1], turns.angles[1]) *
         turn_about(turns.axes[2], turns.angles[2]);
}

Eigen::Vector3d euler_of(const Eigen::Matrix3d& rotation, const EulerOrder& order) {
  const IntrinsicTurns turns = intrinsic_turns(Eigen::Vector3d::Zero(), order);
  const int i = turns.axes[0], j = turns.axes[1], k = 3 - i - j;
  const double sign = handedness(i, j);
  const bool repeats = turns.axes[0] == turns.axes[2];

  // 1. The first turn, from the image of the last axis, which the last turn leaves.
  double across = -sign * rotation(j, k), along = rotation(k, k);
  if (repeats) {
    across = rotation(j, i);
    along = -sign * rotation(k, i);
  }

  // In gimbal lock that image is the first axis, and the last turn does both.
  constexpr double locked = 1e-9;
  const double first = std::hypot(across, along) < locked ? 0 : std::atan2(across, along);

  // 2. The other two, from the rotation without the first.
  const Eigen::Matrix3d rest = turn_about(i, -first) * rotation;
  double second = std::atan2(sign * rest(i, k), rest(k, k));
  double third = std::atan2(sign * rest(j, i), rest(j, j));
  if (repeats) {
    second = std::atan2(-sign * rest(k, i), rest(i, i));
    if (second < -90 * degree) second += two_pi;  // half a turn, which rounding makes negative
    third = std::atan2(-sign * rest(j, k), rest(j, j));
  }

  Eigen::Vector3d angles(first, second, third);
  if (!order.intrinsic) angles.reverseInPlace();
  return angles;
}

Eigen::Isometry3d pose_of_matrix(const Eigen::Matrix4d& matrix) {
  require_finite(matrix.allFinite(), "the matrix");
  throw_if((matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > 1e-9,
           "the last row of the matrix is {:g} {:g} {:g} {:g}, expected 0 0 0 1; is it transposed?",
           matrix(3, 0), matrix(3, 1), matrix(3, 2), matrix(3, 3));

  return pose_from(checked_rotation(matrix.topLeftCorner<3, 3>()), matrix.topRightCorner<3, 1>());
}

Eigen::Isometry3d pose_from(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation;
  pose.translation() = translation;
  return pose;
}

double angle_between(const Eigen::Matrix3d& first, const Eigen::Matrix3d& second) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(first.transpose() * second)).angle();
}

}  // namespace slipstream
