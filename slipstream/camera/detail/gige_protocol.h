#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <netinet/in.h>

#include "slipstream/image/image.h"
#include "slipstream/image/rectangle.h"

namespace slipstream {

/// Where a GigE Vision camera keeps what, 32 bits each: as the standard places it, and the
/// description of Aravis' fake camera.
enum class GigeRegister : std::uint32_t {
  width = 0x100,
  height = 0x104,
  sensor_height = 0x118,
  sensor_width = 0x11c,
  acquisition = 0x124,
  left = 0x130,
  top = 0x134,
  frame_period = 0x138,  ///< us
  trigger_mode = 0x300,
  trigger_source = 0x304,
  software_trigger = 0x30c,
  heartbeat_timeout = 0x938,  ///< ms; half a second to a minute, whatever it says
  control_privilege = 0xa00,
  stream_port = 0xd00,
  packet_size = 0xd04,
  stream_host = 0xd18,
};

/// Frames as a camera's client wants them.
struct GigeStream {
  sockaddr_in to;
  Rectangle region;          ///< within the sensor
  std::size_t packet_bytes;  ///< of pixels in a packet, at least 1
  std::chrono::microseconds period;
  bool is_free, is_triggered;  ///< runs without triggers; waits no longer for one
};

/// The control side of a GigE Vision camera (GVCP), without a socket: registers, with the camera's
/// description behind them, and the one client that may write. Packets come from anybody and may
/// hold anything: they are carried out within the registers' bounds or refused.
class GigeControl {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `memory`: 64 KiB of registers, then the description that is only read.
  explicit GigeControl(std::vector<std::uint8_t> memory);

  /// What a packet is answered with; empty: nothing. A client has control from when it takes it
  /// until it gives it back or is silent for as long as it said; then the registers are again as
  /// they were before it.
  std::vector<std::uint8_t> answer(std::span<const std::uint8_t> packet, const sockaddr_in& from,
                                   Time now);
  /// Nothing where there is no client, it has not started, wants frames elsewhere than at its own
  /// address or a region that is not all on the sensor.
  std::optional<GigeStream> stream(Time now);

  [[nodiscard]] std::uint32_t read(GigeRegister which) const;
  /// What it is from now on, and again when the client goes.
  void write(GigeRegister which, std::uint32_t value);

 private:
  std::uint16_t carry_out(std::uint16_t command, std::span<const std::uint8_t> payload,
                          const sockaddr_in& from, std::vector<std::uint8_t>& result);
  std::uint16_t write_bytes(std::size_t address, std::span<const std::uint8_t> bytes,
                            const sockaddr_in& from);
  void forget_silent_client(Time now);
  void let_client_go();

  std::vector<std::uint8_t> memory_, without_client_;
  std::optional<sockaddr_in> client_;
  Time heard_;  ///< of the client
};

/// Hands the packets of a frame of Mono8 to `send`, as GigE Vision streams it (GVSP): a leader, the
/// pixels of the region, which is within `picture`, and a trailer.
void for_each_packet(const Image<std::uint8_t>& picture, const GigeStream& stream,
                     std::uint16_t frame_number,
                     const std::function<void(std::span<const std::uint8_t>)>& send);

}  // namespace slipstream
