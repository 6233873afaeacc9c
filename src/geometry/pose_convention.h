#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "geometry/rotation.h"

// How robots and programs write poses, and all that a table of numbers may mean.
namespace slipstream {

/// Poses as numbers whose convention is not known yet.
struct PoseTable {
  std::vector<std::string> names;  ///< of the poses
  /// For each pose 16 numbers of a matrix, or the position and 3 or 4 numbers of its rotation.
  std::vector<std::vector<double>> rows;
};

/// How the numbers after the position give a rotation.
struct RotationNotation {
  enum class Kind { euler, vector, quaternion, matrix };

  Kind kind = Kind::euler;
  EulerOrder order{};
  bool degrees = false;  ///< Euler angles, and the length of a rotation vector
  QuaternionOrder quaternion = QuaternionOrder::wxyz;
  bool conjugate = false;   ///< left-handed quaternions
  bool by_columns = false;  ///< a matrix column after column
};

/// "intrinsic zyx in degrees", "rotation vector in radians", "quaternion wxyz", "conjugate
/// quaternion xyzw", "matrix by rows".
std::string name_of(const RotationNotation& notation);

/// All notations that rows of `numbers` numbers, 6, 7 or 16, may have. Throws Error for another
/// number.
std::vector<RotationNotation> notations_of(std::size_t numbers);

/// The pose of a row, its position in the row's unit. Throws Error if the numbers are no rotation
/// in this notation.
Eigen::Isometry3d pose_of(std::span<const double> row, const RotationNotation& notation);

/// The numbers of the table's rows as poses in this notation; nullopt if they are no rotation.
std::vector<std::optional<Eigen::Isometry3d>> poses_of(const PoseTable& table,
                                                       const RotationNotation& notation);

/// The row of a pose in this notation: the inverse of pose_of.
std::vector<double> row_of(const Eigen::Isometry3d& pose, const RotationNotation& notation);

/// All that must be known to read a pose.
struct PoseConvention {
  RotationNotation rotation{};
  double unit = 1;       ///< of the position, mm: 1 or 1000
  bool inverse = false;  ///< the pose of the second frame in the first is written
};

/// The frames of a table's poses, such as "tool" and "base".
struct PoseFrames {
  std::string_view from, to;
};

/// "intrinsic zyx in degrees, mm, tool to base".
std::string name_of(const PoseConvention& convention, const PoseFrames& frames);

/// The poses, mm, of a table in this convention; nullopt as poses_of.
std::vector<std::optional<Eigen::Isometry3d>> poses_of(const PoseTable& table,
                                                       const PoseConvention& convention);

/// The conventions that rows of `numbers` numbers may have and that agree with `known`: parts of
/// their names with commas between, or a robot's name for its notation; empty for all. Throws Error
/// with the part that fits none.
std::vector<PoseConvention> conventions_of(std::size_t numbers, const PoseFrames& frames,
                                           std::string_view known);

/// The robots whose notation is known by name: "abb", "kuka" and so on.
std::vector<std::string> robot_names();

/// The notation of a robot's poses by its name, in any case of letters; nullopt if unknown.
std::optional<RotationNotation> notation_of_robot(std::string_view name);

}  // namespace slipstream
