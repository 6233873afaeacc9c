#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "slipstream/geometry/lens.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/live/live_cloud.h"
#include "slipstream/publish/cdr.h"
#include "slipstream/publish/cloud_sink.h"

namespace slipstream {

/// A type of message: "sensor_msgs/msg/Image", and its definition with those that it names.
struct RosType {
  std::string name;
  std::string definition;
};
RosType point_cloud_type();
RosType image_type();
RosType string_type();

/// Nanoseconds of the world's clock since 1970 at that time of this machine's.
std::uint64_t world_time(std::chrono::steady_clock::time_point time);

/// A cloud as a sink is given it, see CloudSink::put; `time`: world_time.
struct PublishedCloud {
  const LiveCloud& cloud;
  const PublishedRun& run;
  bool alone = false;
  std::uint64_t time = world_time(cloud.newest.host_time);
};

/// A topic that sinks publish for each cloud.
struct CloudTopic {
  std::string name;
  RosType type;
  /// Writes the cloud's message, whose memory is used.
  void (*write)(const PublishedCloud& published, RosMessage& message);
};
/// "image": the cloud's intensity as mono8; without a scanner the window's first frame.
CloudTopic image_topic();
/// "points": write_point_cloud, with what the run knows of its uncertainty unless it goes alone.
CloudTopic points_topic();
/// "depth": sensor_msgs/msg/Image as 32FC1, metres, as write_point_cloud has them.
CloudTopic depth_topic();
/// "camera_info": sensor_msgs/msg/CameraInfo of the run's camera, of the cloud's size.
CloudTopic camera_info_topic();

/// Each into `message`, whose memory is used; `time`: world_time.

/// sensor_msgs/msg/PointCloud2, organised as the camera's pixels: x, y, z in metres (each the
/// cloud's millimetres divided by 1000, rounded to float), NaN where there is no point, and
/// intensity in grey levels of 255, as 32-bit floats. Where the uncertainty is there,
/// sigma_coordinate, sigma_x, sigma_y and sigma_z likewise.
void write_point_cloud(const Cloud& cloud, std::uint64_t time, RosMessage& message,
                       const Uncertainty* uncertainty = nullptr);
/// sensor_msgs/msg/Image: a camera's frame, mono8 or mono16.
void write_image(const Frame& frame, std::uint64_t time, RosMessage& message);
/// The same of a cloud's intensity, mono8.
void write_image(const Cloud& cloud, std::uint64_t time, RosMessage& message);
/// std_msgs/msg/String.
void write_string(std::string_view text, RosMessage& message);

/// What of a PointCloud2's fields write_point_cloud has, in mm, whoever wrote it. Throws Error,
/// naming no file, where it is none, has no x, y, z of 32-bit float, or is not little-endian.
StoredCloud read_point_cloud(std::span<const std::uint8_t> message);
/// The frame of an Image, of a camera of so many bits; its stamp is empty. Throws Error, naming no
/// file, where it is none.
Frame read_frame(std::span<const std::uint8_t> message, int bits);

}  // namespace slipstream
