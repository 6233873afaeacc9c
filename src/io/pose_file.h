#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "geometry/rotation.h"
#include "slipstream/cloud.h"

// Pose files: YAML with the names of two frames, and the motion that maps points of one into the
// other. docs/reference/files.md describes them.
namespace slipstream {

/// How a pose file writes the rotation and the unit.
struct PoseNotation {
  enum class Rotation { matrix, quaternion, rotation_vector, euler };

  Rotation rotation = Rotation::matrix;
  QuaternionOrder quaternion_order = QuaternionOrder::xyzw;
  EulerOrder euler_order{};
  bool degrees = true;  ///< Euler angles and rotation vectors, else radians
  bool metres = false;  ///< else millimetres
};

/// Reads a pose file. Throws Error with file and line if it is not YAML, an entry is unknown,
/// missing, of a wrong length or not finite, there are several rotations, or one that is none.
FramePose read_pose(const std::filesystem::path& file);

/// The same for a file's text; `name`: the file's name in messages.
FramePose pose_in_text(const std::string& text, const std::string& name);

/// The text of a pose file. By default it is the canonical form: a 4x4 matrix in mm.
std::string text_of(const FramePose& pose, const PoseNotation& notation = {});

/// Throws Error unless the file ends in .yaml or .yml, WorldError if it cannot be written.
void write_pose(const std::filesystem::path& file, const FramePose& pose,
                const PoseNotation& notation = {});

/// Parses "matrix", "quaternion xyzw", "quaternion wxyz", "rotation-vector", or "euler" with an
/// order as in euler_order_named, "euler intrinsic zyx". Throws Error for any other text.
PoseNotation pose_notation_named(std::string_view text);

}  // namespace slipstream
