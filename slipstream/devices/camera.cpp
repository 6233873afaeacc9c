#include "slipstream/devices/camera.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/devices/v4l2.h"

namespace slipstream {

#ifndef SLIPSTREAM_CAMERAS  // without Aravis
std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name, const CameraSettings&) {
  throw Error("camera aravis:" + name +
              " needs Aravis, without which this program was built (libaravis-dev, "
              "-DSLIPSTREAM_CAMERAS=ON)");
}

std::vector<CameraDescription> list_genicam_cameras() {
  return {};
}
#endif

namespace {

std::unique_ptr<FrameSource> open_numbered(const std::string& text,
                                           const CameraSettings& settings) {
  const auto number = number_in<int>(text);
  if (!number || *number < 0) {
    throw Error(fmt::format("source v4l2:{}: a number is wanted, as v4l2:0 for /dev/video0", text));
  }
  const std::string path = fmt::format("/dev/video{}", *number);
  return open_v4l2_camera(
      path, [path] { return open_video_device(path); }, settings);
}

struct CameraScheme {
  std::string_view name;
  std::unique_ptr<FrameSource> (*open)(const std::string& what, const CameraSettings& settings);
  std::vector<CameraDescription> (*list)();
};

constexpr std::array camera_schemes{
    CameraScheme{"aravis", open_genicam_camera, list_genicam_cameras},
    CameraScheme{"v4l2", open_numbered, list_v4l2_cameras}};

}  // namespace

std::unique_ptr<FrameSource> open_camera(const std::string& name, const CameraSettings& settings) {
  const std::size_t colon = std::min(name.find(':'), name.size());
  for (const CameraScheme& scheme : camera_schemes) {
    if (name.substr(0, colon) != scheme.name) continue;
    return scheme.open(name.substr(std::min(colon + 1, name.size())), settings);
  }
  throw Error(fmt::format("camera '{}' is unknown; one of aravis:NAME, v4l2:NUMBER", name));
}

std::vector<CameraDescription> list_cameras() {
  std::vector<CameraDescription> cameras;
  for (const auto& [name, open, list] : camera_schemes) {
    for (CameraDescription& camera : list()) {
      camera.name.insert(0, fmt::format("{}:", name));
      cameras.push_back(std::move(camera));
    }
  }
  return cameras;
}

}  // namespace slipstream
