#include "io/scanner_urdf.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Core>
#include <fmt/format.h>

#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

/// The angles of URDF, rad: R = Rz(yaw) Ry(pitch) Rx(roll).
struct RollPitchYaw {
  double roll = 0, pitch = 0, yaw = 0;
};

RollPitchYaw angles_of(const Eigen::Matrix3d& R) {
  const double pitch = std::asin(std::clamp(-R(2, 0), -1.0, 1.0));

  // Looking straight up or down, only the sum of roll and yaw is known.
  constexpr double straight = 1e-9;
  if (std::hypot(R(0, 0), R(1, 0)) < straight) return {0, pitch, std::atan2(-R(0, 1), R(1, 1))};
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

/// Links and joints; `prefix` goes before each name.
std::string frames_of_scanner(const Scanner& scanner, const std::string& prefix) {
  throw_if(!has_geometry(scanner), "the scanner has no geometry");

  // Pose of the projector's frame in the camera's, metres.
  const Eigen::Vector3d at = projector_centre(scanner) / 1000;
  const auto [roll, pitch, yaw] = angles_of(scanner.rotation.transpose());

  return fmt::format(R"(  <link name="{0}camera_link"/>
  <link name="{0}camera_optical"/>
  <link name="{0}projector"/>
  <joint name="{0}camera_optical_joint" type="fixed">
    <parent link="{0}camera_link"/>
    <child link="{0}camera_optical"/>
    <origin xyz="0 0 0" rpy="-1.5707963267948966 0 -1.5707963267948966"/>
  </joint>
  <joint name="{0}projector_joint" type="fixed">
    <parent link="{0}camera_optical"/>
    <child link="{0}projector"/>
    <origin xyz="{1:.9g} {2:.9g} {3:.9g}" rpy="{4:.12g} {5:.12g} {6:.12g}"/>
  </joint>
)",
                     prefix, at.x(), at.y(), at.z(), roll, pitch, yaw);
}

constexpr const char* note =
    "<!-- metres; camera_link: x forward, y left, z up; camera_optical, the frame of clouds, and "
    "projector: x right, y down, z forward -->\n";

}  // namespace

std::string urdf_of(const Scanner& scanner) {
  return fmt::format("<?xml version=\"1.0\"?>\n{}<robot name=\"scanner\">\n{}</robot>\n", note,
                     frames_of_scanner(scanner, ""));
}

std::string xacro_of(const Scanner& scanner) {
  constexpr const char* mount = R"(  <joint name="${prefix}camera_joint" type="fixed">
    <parent link="${parent}"/>
    <child link="${prefix}camera_link"/>
    <xacro:insert_block name="origin"/>
  </joint>
)";

  return fmt::format(
      "<?xml version=\"1.0\"?>\n{}<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n"
      "<xacro:macro name=\"slipstream_scanner\" params=\"prefix:='' parent *origin\">\n"
      "{}{}</xacro:macro>\n</robot>\n",
      note, frames_of_scanner(scanner, "${prefix}"), mount);
}

}  // namespace slipstream
