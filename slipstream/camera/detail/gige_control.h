#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "slipstream/image/rectangle.h"

namespace slipstream {

/// An end of UDP over IPv4, both numbers in the order of this machine.
struct UdpAddress {
  std::uint32_t host = 0;
  std::uint16_t port = 0;

  bool operator==(const UdpAddress&) const = default;
};

/// Where a GigE Vision camera keeps what: the registers that the standard places and those that the
/// description of Aravis' fake camera names.
enum class GigeRegister : std::uint32_t {
  host = 0x24,
  width = 0x100,
  height = 0x104,
  sensor_height = 0x118,
  sensor_width = 0x11c,
  acquisition = 0x124,
  left = 0x130,
  top = 0x134,
  frame_period = 0x138,  ///< us
  frame_trigger = 0x300,
  trigger_source = 0x304,
  software_trigger = 0x30c,
  acquisition_trigger = 0x320,
  heartbeat_timeout = 0x938,  ///< ms; at least 500, at most a minute, whatever it says
  control_privilege = 0xa00,
  stream_port = 0xd00,
  packet_size = 0xd04,
  stream_host = 0xd18,
};

/// Frames as the client of a camera wants them.
struct GigeStream {
  UdpAddress to;
  Rectangle region;              ///< within the sensor
  std::size_t packet_bytes = 0;  ///< of pixels in a packet, at least 1
  std::chrono::microseconds period;
  bool is_free = false;  ///< runs without triggers
  bool ready = false;    ///< that, or the trigger was pulled
};

/// The control side of a GigE Vision camera (GVCP), without a socket: registers, with the camera's
/// description behind them, and the one client that may write. Packets come from anybody and may
/// hold anything: they are carried out within the registers' bounds or refused.
class GigeControl {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `memory`: 64 KiB of registers, then the description that is only read.
  explicit GigeControl(std::vector<std::uint8_t> memory);

  /// What a packet is answered with, empty where that is nothing. A client has control from when it
  /// takes it until it gives it back or is silent for as long as it said; then the registers are
  /// again as they were before it.
  std::vector<std::uint8_t> answer(std::span<const std::uint8_t> packet, UdpAddress from, Time now);
  /// What the client wants at `now`; nothing where there is none, it has not started, wants frames
  /// elsewhere than at its own address or a region that is not all on the sensor.
  std::optional<GigeStream> stream(Time now);

  [[nodiscard]] std::uint32_t read(GigeRegister which) const;
  void write(GigeRegister which, std::uint32_t value);
  /// The same, and what stays when the client goes.
  void set_up(GigeRegister which, std::uint32_t value);

 private:
  enum class Status : std::uint16_t;
  struct Answer;

  Answer carry_out(std::uint16_t command, std::span<const std::uint8_t> payload, UdpAddress from);
  [[nodiscard]] Answer read_bytes(std::uint32_t address, std::uint32_t count) const;
  Status write_bytes(std::uint32_t address, std::span<const std::uint8_t> bytes, UdpAddress from);
  void forget_silent_client(Time now);
  void let_client_go();

  std::vector<std::uint8_t> registers_, description_, without_client_;
  std::optional<UdpAddress> client_;
  Time heard_;  ///< of the client
};

}  // namespace slipstream
