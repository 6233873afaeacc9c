#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "slipstream/devices/camera.h"

namespace slipstream {

/// The system calls that a V4L2 camera is worked with: of a driver, or of a camera that a test
/// makes up. Failures are told by errno, as the calls do.
class VideoDevice {
 public:
  virtual ~VideoDevice() = default;
  /// ioctl: 0, or -1 and errno.
  virtual int control(unsigned long request, void* argument) = 0;
  /// Memory of the driver's, null where it fails; unmapped with `unmap`.
  virtual void* map(std::size_t length, std::size_t offset) = 0;
  virtual void unmap(void* memory, std::size_t length) = 0;
  /// Whether there is something to fetch, or an error to hear of, within that time.
  virtual bool wait(std::chrono::milliseconds timeout) = 0;
};

/// The device of that path, as /dev/video0. Throws WorldError where it cannot be opened.
std::unique_ptr<VideoDevice> open_video_device(const std::string& path);

/// Opens a UVC or other camera of Linux, through V4L2; `name` is what messages call it. Sequence
/// and device time are the driver's, so that frames which it dropped are seen. A camera that was
/// unplugged is opened again when it is back. Throws Error where it does not take a setting,
/// WorldError where it does not answer.
std::unique_ptr<FrameSource> open_v4l2_camera(
    const std::string& name, const std::function<std::unique_ptr<VideoDevice>()>& open,
    const CameraSettings& settings);

/// Cameras of this machine; their names are numbers.
std::vector<CameraDescription> list_v4l2_cameras();

}  // namespace slipstream
