#pragma once

#include <array>
#include <string>
#include <string_view>

#include <Eigen/Geometry>

// The ways in which programs and robots write rotations and poses, read and written. A rotation R
// maps a point p of one frame to R p of another; angles are in radians.
namespace slipstream {

/// Which of the four numbers of a quaternion is its real part: the last or the first.
enum class QuaternionOrder { xyzw, wxyz };

/// Axes of three successive turns: 0 for x, 1 for y, 2 for z. A middle axis differs from both
/// others. `intrinsic`: each turn is about an axis of the turned frame, otherwise about an axis of
/// the fixed frame. Intrinsic zyx is extrinsic xyz with the angles in reverse.
struct EulerOrder {
  std::array<int, 3> axes{2, 1, 0};
  bool intrinsic = true;

  friend bool operator==(const EulerOrder&, const EulerOrder&) = default;
};

/// Parses "intrinsic zyx" or "extrinsic xyz", with any of the 12 orders of axes. Throws Error for
/// any other text, also for an order alone, which robots use for either.
EulerOrder euler_order_named(std::string_view text);
/// The text that euler_order_named reads.
std::string name_of(const EulerOrder& order);

/// Parses "xyzw" or "wxyz"; throws Error for any other text.
QuaternionOrder quaternion_order_named(std::string_view text);
std::string_view name_of(QuaternionOrder order);

/// How far a matrix may be from a rotation, or the norm of a quaternion from 1: programs print as
/// few as four digits.
inline constexpr double rotation_tolerance = 1e-3;

/// The matrix of the cross product: cross_matrix(v) w = v x w.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return matrix;
}

/// The rotation nearest to a matrix, such as a sum of rotations.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix);

/// The rotation nearest to a rounded one. Throws Error, saying how far it is off, if an entry of
/// the matrix is not finite, its columns are not orthogonal unit vectors within
/// rotation_tolerance, or it mirrors.
Eigen::Matrix3d checked_rotation(const Eigen::Matrix3d& matrix);

/// The rotation of a quaternion whose numbers have this order. Throws Error, with the norm, if it
/// differs from 1 by more than rotation_tolerance, or a number is not finite.
Eigen::Matrix3d rotation_of_quaternion(const Eigen::Vector4d& numbers, QuaternionOrder order);
/// The numbers in this order, with a real part that is not negative.
Eigen::Vector4d quaternion_of(const Eigen::Matrix3d& rotation, QuaternionOrder order);

/// Rodrigues' vector: its direction is the axis, its length the angle. Throws Error if a number is
/// not finite.
Eigen::Matrix3d rotation_of_vector(const Eigen::Vector3d& vector);
/// The vector of a rotation; its length is at most pi.
Eigen::Vector3d vector_of(const Eigen::Matrix3d& rotation);

/// The angles are in the order of the turns. Throws Error if one is not finite.
Eigen::Matrix3d rotation_of_euler(const Eigen::Vector3d& angles, const EulerOrder& order);
/// The middle angle is within +-pi/2, or from 0 to pi if the first axis is also the last. Where
/// only the sum or difference of the other two is determined (gimbal lock), one of them is 0.
Eigen::Vector3d euler_of(const Eigen::Matrix3d& rotation, const EulerOrder& order);

/// The pose of a homogeneous matrix with its translation in the last column. Throws Error as
/// checked_rotation, and if its last row is not 0 0 0 1.
Eigen::Isometry3d pose_of_matrix(const Eigen::Matrix4d& matrix);

/// The pose of a rotation and a translation.
Eigen::Isometry3d pose_from(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation);

/// Angle of the rotation between two poses, rad.
double angle_between(const Eigen::Matrix3d& first, const Eigen::Matrix3d& second);

}  // namespace slipstream
