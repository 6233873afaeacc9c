#include "io/gltf_frame.h"

#include <array>
#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

#include "geometry/rotation.h"

namespace slipstream {
using nlohmann::json;
namespace {

/// Other programs keep their own entries beside it.
constexpr const char* frame_key = "slipstream_frame";

}  // namespace

json gltf_node_of(const FramePose* frame) {
  if (frame == nullptr) return {{"mesh", 0}, {"name", camera_frame}};

  const double half = std::sqrt(0.5);
  const Eigen::Vector3d place = frame->transform.translation() / 1000;
  const Eigen::Vector4d turn = quaternion_of(frame->transform.linear(), QuaternionOrder::xyzw);
  const json camera{{"translation", {place.x(), place.y(), place.z()}},
                    {"rotation", {turn[0], turn[1], turn[2], turn[3]}}};

  return {{"mesh", 0},
          {"name", frame->to},
          {"rotation", {-half, 0, 0, half}},
          {"extras", {{frame_key, frame->to}, {"camera", camera}}}};
}

std::shared_ptr<const FramePose> gltf_frame_in(const json& document) {
  const json nodes = document.value("nodes", json::array());
  const json extras = nodes.empty() ? json() : nodes.front().value("extras", json());
  if (!extras.is_object() || !extras.contains(frame_key)) return nullptr;

  const json& camera = extras.at("camera");
  const auto place = camera.at("translation").get<std::array<double, 3>>();
  const auto turn = camera.at("rotation").get<std::array<double, 4>>();
  const std::string name = extras.at(frame_key).get<std::string>();
  require_frame_name(name);

  const Eigen::Matrix3d rotation =
      rotation_of_quaternion(Eigen::Vector4d(turn.data()), QuaternionOrder::xyzw);
  return std::make_shared<const FramePose>(FramePose{
      std::string(camera_frame), name, pose_from(rotation, 1000 * Eigen::Vector3d(place.data()))});
}

}  // namespace slipstream
