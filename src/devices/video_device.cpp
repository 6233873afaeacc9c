#include "devices/video_device.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <string>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "slipstream/error.h"

namespace slipstream {
namespace {

class FileDevice : public VideoDevice {
 public:
  explicit FileDevice(const std::string& path)
      : descriptor_(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)) {
    if (descriptor_ >= 0) return;
    throw WorldError(fmt::format("cannot open camera {}: {}", path, std::strerror(errno)));
  }
  FileDevice(const FileDevice&) = delete;
  FileDevice& operator=(const FileDevice&) = delete;

  ~FileDevice() override { ::close(descriptor_); }

  int control(unsigned long request, void* argument) override {
    int result = 0;
    do {
      result = ::ioctl(descriptor_, request, argument);
    } while (result < 0 && errno == EINTR);
    return result;
  }

  void* map(std::size_t length, std::size_t offset) override {
    void* memory = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor_,
                          static_cast<off_t>(offset));
    return memory == MAP_FAILED ? nullptr : memory;
  }

  void unmap(void* memory, std::size_t length) override { ::munmap(memory, length); }

  bool wait(std::chrono::milliseconds timeout) override {
    pollfd events{descriptor_, POLLIN, 0};
    return ::poll(&events, 1, static_cast<int>(timeout.count())) > 0;
  }

 private:
  int descriptor_;
};

}  // namespace

std::unique_ptr<VideoDevice> open_video_device(const std::string& path) {
  return std::make_unique<FileDevice>(path);
}

}  // namespace slipstream
