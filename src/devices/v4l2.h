#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "slipstream/camera.h"

namespace slipstream {

/// System calls of a V4L2 driver, or of a simulated one in tests; errors in errno.
class VideoDevice {
 public:
  virtual ~VideoDevice() = default;
  /// ioctl: 0, or -1 and errno.
  virtual int control(unsigned long request, void* argument) = 0;
  /// Maps driver memory, null on failure; release with `unmap`.
  virtual void* map(std::size_t length, std::size_t offset) = 0;
  virtual void unmap(void* memory, std::size_t length) = 0;
  /// Waits for a frame or an error; false after the timeout.
  virtual bool wait(std::chrono::milliseconds timeout) = 0;
};

/// Opens a device such as /dev/video0. Throws WorldError if it cannot be opened.
std::unique_ptr<VideoDevice> open_video_device(const std::string& path);

/// Opens a camera through V4L2; `name` is used in messages. Sequence number and device time come
/// from the driver, so that dropped frames are noticed. An unplugged camera is reopened when it is
/// back. Throws Error if it refuses a setting, WorldError if it does not answer.
std::unique_ptr<FrameSource> open_v4l2_camera(
    const std::string& name, const std::function<std::unique_ptr<VideoDevice>()>& open,
    const CameraSettings& settings);

/// V4L2 cameras of this machine; their names are numbers.
std::vector<CameraDescription> list_v4l2_cameras();

}  // namespace slipstream
