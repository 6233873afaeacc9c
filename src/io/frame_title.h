#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "slipstream/cloud.h"

// How the headers of cloud and mesh files name the frame of their points.
namespace slipstream {

/// "slipstream, camera frame, mm", with the name of the frame; null: the camera's.
std::string frame_title(const FramePose* frame);

/// The camera's place in the frame, mm, and its rotation as a quaternion with w first, as in PCD:
/// "0 0 0 1 0 0 0" in its own.
std::string viewpoint_text(const FramePose* frame);

/// The title as a comment, and if it is not the camera's frame also "viewpoint " with the camera's
/// place. `mark`: begins each line, "comment" or "#".
std::string frame_comments(const FramePose* frame, std::string_view mark);

/// Collects the lines of a header that say which frame a file is in.
class FrameTitle {
 public:
  /// Takes a line that contains a title, or begins with "viewpoint" in any case; ignores any other.
  void read(std::string_view line);

  /// The pose from the camera's frame; null if the file is in the camera's or names none. A file
  /// without the camera's place has it at the origin.
  [[nodiscard]] std::shared_ptr<const FramePose> frame() const;

 private:
  std::string name_;
  std::optional<Eigen::Isometry3d> camera_;
};

/// The frame that the comments at the beginning of a text name, each behind "# "; null if none.
std::shared_ptr<const FramePose> frame_of_comments(std::string_view text);

}  // namespace slipstream
