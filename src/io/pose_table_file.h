#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "geometry/pose_convention.h"

namespace slipstream {

/// Reads a list of poses:
///   .yaml, .yml  a list, alone or under a key, of maps or lists of numbers; also one PoseArray as
///                ROS prints it
///   others       a pose a line, with its numbers separated by commas, semicolons, blanks or
///                brackets; a line of column names, or names beside the numbers as in programs of
///                robots, {X 100, Y 0, Z 300, A 0, B 90, C 0}
/// Recognised names are x y z with rx ry rz, a b c, w p r, o a t, u v w, roll pitch yaw, or qw qx
/// qy qz, q1 to q4; other columns are ignored. Without names, 6, 7, 12 or 16 numbers are taken in
/// their order. A word before the numbers, or the column `name`, is the pose's name. `columns`:
/// names of the columns, "name,x,y,z,a,b,c", with "-" for one to ignore; empty: the file's own.
/// Throws Error with file and line if that gives no poses.
PoseTable read_pose_table(const std::filesystem::path& path, std::string_view columns = {});

/// The same for a file's text; `name`: the file's name in messages.
PoseTable pose_table_in_text(const std::string& text, bool is_yaml, std::string_view columns,
                             const std::string& name);

/// The text of a table with these column names, as read_pose_table reads it.
std::string text_of(const PoseTable& table, std::string_view columns);

}  // namespace slipstream
