#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "slipstream/live/live_cloud.h"

namespace slipstream {

/// A message of ROS 2 in its binary form: CDR, little-endian.
using RosMessage = std::vector<std::uint8_t>;

/// A type of message: "sensor_msgs/msg/Image", and its definition with those that it names.
struct RosType {
  std::string name;
  std::string definition;
};
RosType point_cloud_type();
RosType image_type();

/// Each into `message`, whose memory is used; `time`: nanoseconds of the world's clock since 1970.

/// sensor_msgs/msg/PointCloud2, organised as the camera's pixels: x, y, z in metres (each the
/// cloud's millimetres divided by 1000, rounded to float), NaN where there is no point, and
/// intensity in grey levels of 255, as 32-bit floats.
void write_point_cloud(const Cloud& cloud, std::uint64_t time, RosMessage& message);
/// sensor_msgs/msg/Image: the cloud's intensity as mono8; without a scanner the window's first
/// frame, mono8 or mono16.
void write_image(const LiveCloud& cloud, std::uint64_t time, RosMessage& message);

}  // namespace slipstream
