#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "slipstream/ros_messages.h"

// tf2_msgs/msg/TFMessage, as on ROS's topic /tf_static: where frames are.
namespace slipstream {

inline constexpr std::string_view transform_topic = "tf_static";

RosType transform_type();

/// Writes the pose of the frame `pose.from` in `pose.to`, in metres. `camera`: name to write for
/// the camera's frame.
void write_transform(const FramePose& pose, std::string_view camera, std::uint64_t time,
                     RosMessage& message);

/// The poses of a message, mm. Throws Error without a file name if it is none, or a rotation is not
/// one.
std::vector<FramePose> read_transforms(std::span<const std::uint8_t> message);

}  // namespace slipstream
