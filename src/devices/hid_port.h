#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace slipstream::dlp {

/// A USB connection that exchanges 64-byte reports, without their number.
class HidPort {
 public:
  using Report = std::array<std::uint8_t, 64>;

  virtual ~HidPort() = default;
  /// Throws WorldError if the device is gone, like `read`.
  virtual void write(const Report& report) = 0;
  /// nullopt on timeout.
  virtual std::optional<Report> read(std::chrono::milliseconds timeout) = 0;
};

/// Texas Instruments' controllers of the LightCrafter 4500, and 6500 and 9000, by USB product.
enum class Controller : std::uint16_t { dlpc350 = 0x6401, dlpc900 = 0xC900 };
constexpr std::string_view name_of(Controller controller) {
  return controller == Controller::dlpc350 ? "DLPC350" : "DLPC900";
}

/// Connected controllers and their paths; none in builds without hidapi.
std::vector<std::pair<Controller, std::string>> list_controllers();
using OpenedController = std::pair<Controller, std::unique_ptr<HidPort>>;

/// Throws WorldError without exactly one controller or access to it, Error without hidapi.
OpenedController open_controller();

}  // namespace slipstream::dlp
