#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

namespace slipstream {

/// A pose as a text file gives it. Files do not say whether the scalar part of a quaternion comes
/// first, nor whether a pose leads to the view or from it.
struct ListedPose {
  std::string name{};
  Eigen::Isometry3d scalar_last = Eigen::Isometry3d::Identity();   ///< quaternion as x y z w
  Eigen::Isometry3d scalar_first = Eigen::Isometry3d::Identity();  ///< quaternion as w x y z
  bool is_matrix = false;  ///< no quaternion: both are the same
};

/// Reads a line for each view: its name, then x y z and a quaternion, or the 12 or 16 numbers of a
/// matrix, row by row; separated by blanks or commas. A name in double quotes may have any
/// characters, a quote as two. Lines that begin with # are comments. `unit`: mm of its lengths.
/// Throws Error with file and line if it is malformed.
std::vector<ListedPose> read_pose_list(const std::filesystem::path& path, double unit = 1);

/// Writes a line for each: the name, in quotes if it needs them, x y z and the quaternion x y z w,
/// from the view's frame to the model's. `unit`: mm of the unit of x y z, which a comment names.
void write_pose_list(const std::filesystem::path& path,
                     const std::vector<std::pair<std::string, Eigen::Isometry3d>>& poses,
                     double unit = 1);

}  // namespace slipstream
