#pragma once

#include <string>

#include "app/commands.h"
#include "io/pose_file.h"

namespace slipstream::app {

/// How a command prints and writes the pose it has found.
struct PoseOutputFlags {
  PoseNotation notation{};
  bool metres = false, radians = false;
  std::string output;  ///< file; empty: only printed
};

/// Adds -o, --as, --metres and --radians.
void add_pose_output_flags(const FlagGroup& group, PoseOutputFlags& flags);

/// Prints the pose and adds it to the JSON document; writes it if a file is named.
void put_pose(const FramePose& pose, const PoseOutputFlags& flags, Output& output);

}  // namespace slipstream::app
