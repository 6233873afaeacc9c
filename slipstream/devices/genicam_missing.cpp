// Stands in for genicam.cpp where Aravis is not installed.
#include "slipstream/base/error.h"
#include "slipstream/devices/genicam.h"

namespace slipstream {

std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name, const CameraSettings&) {
  throw Error("camera aravis:" + name +
              " needs Aravis, without which this program was built (libaravis-dev, "
              "-DSLIPSTREAM_CAMERAS=ON)");
}

std::vector<CameraDescription> list_genicam_cameras() {
  return {};
}

}  // namespace slipstream
