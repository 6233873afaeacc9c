#include "slipstream/devices/open_camera.h"

#include <cstddef>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/number_text.h"
#include "slipstream/devices/genicam.h"
#include "slipstream/devices/v4l2_source.h"

namespace slipstream {
namespace {

std::unique_ptr<FrameSource> open_v4l2_camera(const std::string& text,
                                              const CameraSettings& settings) {
  const auto number = number_in<int>(text);
  if (!number || *number < 0) {
    throw Error(fmt::format("source v4l2:{}: a number is wanted, as v4l2:0 for /dev/video0", text));
  }
  return std::make_unique<V4l2Source>(*number, settings);
}

}  // namespace

std::unique_ptr<FrameSource> open_camera(const std::string& name, const CameraSettings& settings) {
  const std::size_t colon = name.find(':');
  const std::string scheme = name.substr(0, colon);
  const std::string rest = colon == std::string::npos ? "" : name.substr(colon + 1);
  if (scheme == "aravis") return open_genicam_camera(rest, settings);
  if (scheme == "v4l2") return open_v4l2_camera(rest, settings);
  throw Error(fmt::format("camera '{}' is unknown; one of aravis:NAME, v4l2:NUMBER", name));
}

std::vector<CameraDescription> list_cameras() {
  std::vector<CameraDescription> cameras;
  const auto add = [&](std::string_view scheme, std::vector<CameraDescription> found) {
    for (CameraDescription& camera : found) {
      camera.name.insert(0, scheme);
      cameras.push_back(std::move(camera));
    }
  };
  add("aravis:", list_genicam_cameras());
  add("v4l2:", list_v4l2_cameras());
  return cameras;
}

}  // namespace slipstream
