#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

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

}  // namespace slipstream
