#include "publish/transform_message.h"

#include <string>

#include "base/throw_if-inl.h"
#include "geometry/rotation.h"
#include "publish/cdr.h"
#include "publish/message_definition.h"

namespace slipstream {

RosType transform_type() {
  return {"tf2_msgs/msg/TFMessage",
          "geometry_msgs/TransformStamped[] transforms\n" +
              named_definition("geometry_msgs/TransformStamped",
                               "std_msgs/Header header\nstring child_frame_id\n"
                               "geometry_msgs/Transform transform\n") +
              named_definition(
                  "geometry_msgs/Transform",
                  "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n") +
              named_definition("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n") +
              named_definition("geometry_msgs/Quaternion",
                               "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n") +
              header_definition()};
}

void write_transform(const FramePose& pose, std::string_view camera, std::uint64_t time,
                     RosMessage& message) {
  const auto named = [&](const std::string& frame) -> std::string_view {
    return frame == camera_frame ? camera : std::string_view(frame);
  };

  // One transform: the parent frame in the header, then the child's name and its pose.
  Cdr cdr(message);
  cdr.add_count(1).add_time(time).add_text(named(pose.to)).add_text(named(pose.from));

  const Eigen::Vector3d metres = pose.transform.translation() / 1000;
  for (const double number : metres) cdr.add(number);
  for (const double number : quaternion_of(pose.transform.linear(), QuaternionOrder::xyzw)) {
    cdr.add(number);
  }
}

std::vector<FramePose> read_transforms(std::span<const std::uint8_t> message) {
  CdrReader cdr(message);
  std::vector<FramePose> poses;

  for (std::uint32_t left = cdr.count(); left > 0; --left) {
    cdr.count();  // seconds
    cdr.count();
    FramePose pose;
    pose.to = cdr.text();
    pose.from = cdr.text();

    Eigen::Vector3d metres;
    Eigen::Vector4d turn;
    for (double& number : metres) number = cdr.get<double>();
    for (double& number : turn) number = cdr.get<double>();
    throw_if(!metres.allFinite(), "the transform of {} is not finite", pose.from);

    pose.transform = pose_from(rotation_of_quaternion(turn, QuaternionOrder::xyzw), 1000 * metres);
    poses.push_back(std::move(pose));
  }
  return poses;
}

}  // namespace slipstream
