#include "slipstream/camera/genicam.h"

#include <arv.h>

#include "slipstream/camera/aravis_source.h"

namespace slipstream {

std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name,
                                                 const CameraSettings& settings) {
  return std::make_unique<AravisSource>(name, settings);
}

std::vector<CameraDescription> list_genicam_cameras() {
  const auto text = [](const char* value) { return std::string(value == nullptr ? "" : value); };
  arv_update_device_list();
  std::vector<CameraDescription> cameras;
  for (unsigned int i = 0; i < arv_get_n_devices(); ++i) {
    cameras.push_back({.name = text(arv_get_device_id(i)),
                       .vendor = text(arv_get_device_vendor(i)),
                       .model = text(arv_get_device_model(i)),
                       .serial = text(arv_get_device_serial_nbr(i)),
                       .address = text(arv_get_device_address(i)),
                       .protocol = text(arv_get_device_protocol(i))});
  }
  return cameras;
}

}  // namespace slipstream
