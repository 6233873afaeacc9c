#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <netinet/in.h>

#include "slipstream/base/size.h"

namespace slipstream {

/// Where a GigE Vision camera keeps what, 32 bits each: as the standard places it; and where our
/// cameras' descriptions say.
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
  // of the standard
  heartbeat_timeout = 0x938,  ///< ms; half a second to a minute, whatever it says
  control_privilege = 0xa00,
  stream_port = 0xd00,
  packet_size = 0xd04,
  packet_delay = 0xd08,  ///< ticks of the camera's clock
  stream_host = 0xd18,
  stream_configuration = 0xd24,
};

/// Frames as a camera's client wants them.
struct GigeStream {
  sockaddr_in to;
  Rectangle region;          ///< within the sensor
  std::size_t packet_bytes;  ///< of pixels in a packet, at least 1
  std::chrono::microseconds period;
  std::chrono::nanoseconds packet_delay;  ///< at least, from one packet to the next
  bool is_free, is_triggered;             ///< runs without triggers; waits no longer for one
};

/// Packets of a block that its client has not got.
struct GigeResend {
  std::uint64_t block = 0;
  std::size_t first = 0, last = 0;
  bool long_numbers = false;  ///< as blocks of several parts have
};

/// How a camera answers.
enum class GigeStatus : std::uint16_t {
  success = 0,
  not_implemented = 0x8001,
  invalid_parameter = 0x8002,
  invalid_address = 0x8003,
  write_protected = 0x8004,
  access_denied = 0x8006,
};

/// The control side of a GigE Vision camera (GVCP), without a socket: registers, with the camera's
/// description behind them, and the one client that may write. Packets come from anybody and may
/// hold anything: they are carried out within the registers' bounds or refused.
class GigeControl {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// From and up to where a client may write.
  using Writable = std::vector<std::pair<std::size_t, std::size_t>>;
  /// Whether a register may have that value; called before it has.
  using Accept = std::function<GigeStatus(GigeRegister, std::uint32_t)>;

  /// Of Aravis' fake camera: nothing of its name, sensor and description.
  static Writable fake_camera();

  /// `memory`: 64 KiB of registers, then the description that is only read.
  explicit GigeControl(std::vector<std::uint8_t> memory, Writable writable = fake_camera(),
                       Accept accept = {});

  /// What a packet is answered with; empty: nothing. A client has control from when it takes it
  /// until it gives it back or is silent for as long as it said; then the registers are again as
  /// they were before it.
  std::vector<std::uint8_t> answer(std::span<const std::uint8_t> packet, const sockaddr_in& from,
                                   Time now);
  /// Nothing where there is no client, it has not started, wants frames elsewhere than at its own
  /// address or a region that is not all on the sensor.
  std::optional<GigeStream> stream(Time now);
  /// Where the client takes its frames, at its own address.
  [[nodiscard]] std::optional<sockaddr_in> stream_target() const;
  /// What the client asked to have again since this was last called; the newest, of several.
  std::optional<GigeResend> take_resend() { return std::exchange(resend_, std::nullopt); }
  /// Clients that had control and fell silent.
  [[nodiscard]] std::uint64_t silent_clients() const { return silent_clients_; }

  [[nodiscard]] const std::vector<std::uint8_t>& memory() const { return memory_; }
  [[nodiscard]] std::uint32_t read(GigeRegister which) const;
  /// What it is from now on, and again when the client goes.
  void write(GigeRegister which, std::uint32_t value);
  /// What it is until the client goes.
  void change(GigeRegister which, std::uint32_t value);

 private:
  GigeStatus carry_out(std::uint16_t command, std::span<const std::uint8_t> payload,
                       const sockaddr_in& from, std::vector<std::uint8_t>& result);
  GigeStatus write_bytes(std::size_t address, std::span<const std::uint8_t> bytes,
                         const sockaddr_in& from);
  void note_resend(std::span<const std::uint8_t> payload, bool long_numbers,
                   const sockaddr_in& from);
  void forget_silent_client(Time now);
  void let_client_go();

  std::vector<std::uint8_t> memory_, without_client_;
  Writable writable_;
  Accept accept_;
  std::optional<sockaddr_in> client_;
  Time heard_;  ///< of the client
  std::optional<GigeResend> resend_;
  std::uint64_t silent_clients_ = 0;
};

}  // namespace slipstream
