// Stands in for genicam.cpp and camera_serve.cpp where Aravis is not installed.
#include "app/genicam.h"
#include "slipstream/error/error.h"

namespace slipstream::app {

std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name, const CameraFlags&,
                                                 std::optional<double>, int) {
  throw Error("camera aravis:" + name +
              " needs Aravis, without which this program was built (libaravis-dev, "
              "-DSLIPSTREAM_CAMERAS=ON)");
}

std::vector<CameraDescription> genicam_cameras() {
  return {};
}

void add_camera_serve(CLI::App&, SharedFlags&, Command&) {}

}  // namespace slipstream::app
