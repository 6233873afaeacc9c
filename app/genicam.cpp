#include "app/genicam.h"

#include "slipstream/camera/aravis_source.h"
#include "slipstream/camera/camera_list.h"

namespace slipstream::app {

std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name, const CameraFlags& flags,
                                                 std::optional<double> rate, int cycle) {
  CameraSettings settings;
  settings.gain = flags.gain;
  settings.frame_rate = rate;
  settings.pixel_format = mono_format_named(flags.pixel_format);
  settings.trigger = flags.trigger;
  settings.packet_size = flags.packet_size;
  settings.cycle = cycle;
  if (flags.exposure) settings.exposure = *flags.exposure / 1e3;
  if (flags.region) {
    const Region region = region_from(*flags.region);
    settings.region = CameraRegion{region.x, region.y, region.size};
  }
  return std::make_unique<AravisSource>(name, settings);
}

std::vector<CameraDescription> genicam_cameras() {
  return list_genicam_cameras();
}

}  // namespace slipstream::app
