#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

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

}  // namespace slipstream
