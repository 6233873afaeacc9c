#include "devices/hid_port.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/error.h"

#ifdef SLIPSTREAM_DLP
#include <hidapi.h>
#include <unistd.h>
#endif

namespace slipstream::dlp {

#ifdef SLIPSTREAM_DLP
namespace {

class OpenedPort final : public HidPort {
 public:
  explicit OpenedPort(const std::string& path)
      : path_(path), device_(::hid_open_path(path.c_str()), &::hid_close) {
    if (device_) return;
    const bool may = ::access(path.c_str(), R_OK | W_OK) == 0;
    throw WorldError(path + (may ? ": cannot be opened" : ": no permission; add a udev rule"));
  }

  void write(const Report& report) override {
    std::array<std::uint8_t, 65> numbered{};  // report 0
    std::copy(report.begin(), report.end(), numbered.begin() + 1);
    require(::hid_write(device_.get(), numbered.data(), numbered.size()));
  }

  std::optional<Report> read(std::chrono::milliseconds timeout) override {
    Report report{};
    const int count = ::hid_read_timeout(device_.get(), report.data(), report.size(),
                                         static_cast<int>(timeout.count()));
    require(count);
    return count > 0 ? std::optional(report) : std::nullopt;
  }

 private:
  void require(int result) const {
    if (result < 0) throw WorldError("the projector at " + path_ + " is gone");
  }

  std::string path_;
  std::unique_ptr<hid_device, decltype(&::hid_close)> device_;
};

}  // namespace

std::vector<std::pair<Controller, std::string>> list_controllers() {
  std::vector<std::pair<Controller, std::string>> found;
  for (const Controller controller : {Controller::dlpc350, Controller::dlpc900}) {
    // 0x0451 is Texas Instruments' USB vendor number.
    hid_device_info* const all = ::hid_enumerate(0x0451, static_cast<std::uint16_t>(controller));
    for (const hid_device_info* each = all; each != nullptr; each = each->next) {
      // Only the first interface of a device; -1 stands for an unknown number.
      if (each->interface_number <= 0) found.emplace_back(controller, each->path);
    }
    ::hid_free_enumeration(all);
  }
  return found;
}

OpenedController open_controller() {
  const auto found = list_controllers();
  if (found.empty()) throw WorldError("no DLPC350 or DLPC900 is connected by USB");
  if (found.size() > 1) throw WorldError("several DLPC350 or DLPC900 are connected; leave one");
  return {found[0].first, std::make_unique<OpenedPort>(found[0].second)};
}
#else
std::vector<std::pair<Controller, std::string>> list_controllers() {
  return {};
}

OpenedController open_controller() {
  throw Error(
      "this program was built without DLP controllers (libhidapi-dev, -DSLIPSTREAM_DLP=ON)");
}
#endif

}  // namespace slipstream::dlp
