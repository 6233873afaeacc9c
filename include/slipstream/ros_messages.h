#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/cloud_file.h"
#include "slipstream/cloud_sink.h"

namespace slipstream {

/// A ROS 2 message in little-endian CDR.
using RosMessage = std::vector<std::uint8_t>;

struct RosHeader {
  std::uint64_t time;  ///< Unix time in ns
  std::string_view frame_id = camera_frame;
};

/// A message type, e.g. "sensor_msgs/msg/Image", and its definition with the types it uses.
struct RosType {
  std::string name;
  std::string definition;
};

RosType point_cloud_type();
RosType image_type();

/// Unix time in ns of a time on this machine's steady clock.
std::uint64_t world_time(std::chrono::steady_clock::time_point time);

/// Arguments of CloudSink::put, and the header of the cloud's messages.
struct PublishedCloud {
  const LiveCloud& cloud;
  const PublishedRun& run;
  bool alone = false;
  RosHeader header{world_time(cloud.newest.host_time), run.frame_id};
};

/// A topic published for each cloud.
struct CloudTopic {
  std::string name;
  RosType type;
  /// Writes the cloud's message, reusing its memory.
  void (*write)(const PublishedCloud& published, RosMessage& message);
};

/// "image": the cloud's colours as rgb8, or its intensity as mono8; without a scanner, the window's
/// first frame.
CloudTopic image_topic();
/// "points": write_point_cloud in the run's frame, with the uncertainty, if known and if not sent
/// `alone`. The other topics are the camera's.
CloudTopic points_topic();
/// "depth": sensor_msgs/msg/Image as 32FC1, metres, like write_point_cloud.
CloudTopic depth_topic();
/// "camera_info": sensor_msgs/msg/CameraInfo of the run's camera at the cloud's size.
CloudTopic camera_info_topic();

/// All write into `message`, reusing its memory.

/// sensor_msgs/msg/PointCloud2 of 32-bit floats, organised like the camera's pixels: x, y, z in
/// metres (the cloud's millimetres divided by 1000), NaN if invalid; intensity in grey levels of
/// 255; with uncertainty also sigma_coordinate, sigma_x, sigma_y and sigma_z; with colours also
/// rgb, a float of the bytes blue, green, red and 0.
void write_point_cloud(const Cloud& cloud, const RosHeader& header, RosMessage& message,
                       const Uncertainty* uncertainty = nullptr);

/// sensor_msgs/msg/Image: a camera's frame, mono8 or mono16.
void write_image(const Frame& frame, const RosHeader& header, RosMessage& message);
/// sensor_msgs/msg/Image of a cloud's colours, rgb8, or its intensity, mono8.
void write_image(const Cloud& cloud, const RosHeader& header, RosMessage& message);

/// Reads the fields of write_point_cloud from any PointCloud2, converted to mm, with the name of
/// its frame, as if that had the camera at its origin. Throws Error, without a file name, if it is
/// not a PointCloud2, has no 32-bit float x, y, z, or is not little-endian.
StoredCloud read_point_cloud(std::span<const std::uint8_t> message);
/// The frame of an Image with this bit depth, without its timestamp. Throws Error without a file
/// name.
Frame read_frame(std::span<const std::uint8_t> message, int bits);

}  // namespace slipstream
