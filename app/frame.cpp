#include "app/frame.h"

#include <vector>

namespace slipstream::app {
namespace {

struct PoseFlags {
  std::string pose;
  PoseOutputFlags output;
};

struct ComposeFlags {
  std::vector<std::string> poses;
  PoseOutputFlags output;
};

void convert_pose(const PoseFlags& flags, Output& output) {
  put_pose(read_pose(flags.pose), flags.output, output);
}

void invert_pose(const PoseFlags& flags, Output& output) {
  put_pose(inverse(read_pose(flags.pose)), flags.output, output);
}

/// Whether the pose begins or ends in the frame.
bool touches(const FramePose& pose, const std::string& frame) {
  return pose.from == frame || pose.to == frame;
}

void compose_poses(const ComposeFlags& flags, Output& output) {
  throw_if(flags.poses.size() < 2, "one pose file; name two or more to compose");
  std::vector<FramePose> poses;
  for (const std::string& file : flags.poses) poses.push_back(read_pose(file));

  // The first pose ends in the frame that it shares with the second; the names tell which.
  FramePose whole = poses.front();
  const FramePose& second = poses[1];
  throw_if(!touches(second, whole.from) && !touches(second, whole.to),
           "{} is between the frames {} and {}, and {} between {} and {}; they share none",
           flags.poses[0], whole.from, whole.to, flags.poses[1], second.from, second.to);
  if (!touches(second, whole.to)) whole = inverse(whole);

  for (std::size_t i = 1; i < poses.size(); ++i) {
    throw_if(!touches(poses[i], whole.to),
             "{} is between the frames {} and {}, but the poses before it end in {}",
             flags.poses[i], poses[i].from, poses[i].to, whole.to);
    whole = compose(whole, pose_from_frame(poses[i], whole.to));
  }

  throw_if(whole.from == whole.to, "the poses lead from the frame {} back to it", whole.from);
  put_pose(whole, flags.output, output);
}

}  // namespace

void add_pose_output_flags(const FlagGroup& group, PoseOutputFlags& flags) {
  group.add_output("-o,--output", flags.output, "pose file to write: .yaml");

  const auto choose = [&flags](const std::string& text) {
    flags.notation = pose_notation_named(text);
  };
  group
      .add_read<>("--as", choose,
                  "notation: matrix, 'quaternion xyzw', 'quaternion wxyz', rotation-vector, or "
                  "euler with its order, e.g. 'euler intrinsic zyx'")
      ->default_str("matrix");
  group.add("--metres", flags.metres, "translation in metres instead of millimetres");
  group.add("--radians", flags.radians, "angles in radians instead of degrees");
}

void put_pose(const FramePose& pose, const PoseOutputFlags& flags, Output& output) {
  PoseNotation notation = flags.notation;
  notation.metres = flags.metres;
  notation.degrees = !flags.radians;

  output.document.update(json_of(pose));

  // A pose that cannot be written is not printed either.
  if (!flags.output.empty()) write_pose(flags.output, pose, notation);

  std::string text = text_of(pose, notation);
  text.pop_back();  // the last line break
  output.say_lines(text);
  if (!flags.output.empty()) output.add_file("pose", flags.output);
}

void add_frame(const Commands& program) {
  const Commands frame = program.add_group("frame", "convert poses between frames, and find them");

  // 1. slipstream frame convert, invert, compose
  const auto [convert, converted] =
      frame.add(convert_pose, "convert", "write a pose in another notation or unit");
  required(convert.add_file("pose", converted.pose, "pose file"));
  add_pose_output_flags(convert, converted.output);
  convert.examples({"frame convert base.yaml --as 'euler intrinsic zyx'"});

  const auto [invert, inverted] =
      frame.add(invert_pose, "invert", "write a pose in the other direction");
  required(invert.add_file("pose", inverted.pose, "pose file"));
  add_pose_output_flags(invert, inverted.output);

  const auto [compose, composed] =
      frame.add(compose_poses, "compose", "join poses: camera to flange, flange to base, ...");
  required(compose.add_file(
      "poses", composed.poses,
      "pose files in order, each sharing a frame with the next; their directions may differ"));
  add_pose_output_flags(compose, composed.output);
  compose.examples({"frame compose flange.yaml base.yaml -o camera-in-base.yaml"});

  // 2. slipstream frame points, planes, board, marker
  add_found_frames(frame);
}

}  // namespace slipstream::app
