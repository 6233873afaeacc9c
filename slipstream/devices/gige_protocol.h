#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <netinet/in.h>

#include "slipstream/base/image.h"

namespace slipstream {

/// 32-bit registers of a GigE Vision camera, by the standard or by our cameras' descriptions.
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

/// The control side of a GigE Vision camera (GVCP), without a socket: registers, the description
/// behind them, and the one client that may write. Packets are untrusted.
class GigeControl {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// From and up to where a client may write.
  using Writable = std::vector<std::pair<std::size_t, std::size_t>>;
  /// Whether a register may have that value; called before it has.
  using Accept = std::function<GigeStatus(GigeRegister, std::uint32_t)>;

  /// `memory`: 64 KiB of registers, then the description that is only read. `writable`: by default
  /// of Aravis' fake camera, nothing of its name and sensor.
  explicit GigeControl(std::vector<std::uint8_t> memory,
                       Writable writable = {{0x100, 0x118},
                                            {0x120, 0x200},
                                            {0x300, 0x400},
                                            {0x938, 0x93c},
                                            {0xa00, 0xa04},
                                            {0xd00, 0xd40}},
                       Accept accept = {})
      : memory_(std::move(memory)),
        without_client_(memory_),
        writable_(std::move(writable)),
        accept_(std::move(accept)) {}

  /// The answer to a packet, or empty. A client has control from when it takes it until it gives it
  /// back or is silent for as long as it said; then the registers are reset to before it.
  std::vector<std::uint8_t> answer(std::span<const std::uint8_t> packet, const sockaddr_in& from,
                                   Time now);
  /// None unless a client has started, with frames to its own address and a region on the sensor.
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

/// What a picture shows, as GenICam numbers it.
enum class GigeComponent : std::uint16_t { intensity = 1, range = 4, confidence = 6 };

/// Its pixels as GenICam numbers them (PFNC).
enum class GigePixels : std::uint32_t {
  mono8 = 0x01080001,
  confidence8 = 0x010800c6,
  coord3d_c16 = 0x011000b8,
  coord3d_c32f = 0x012000bf,
  coord3d_abc32f = 0x026000c0,
};

constexpr std::size_t bytes_per_pixel(GigePixels pixels) {
  return (static_cast<std::uint32_t>(pixels) >> 16 & 0xff) / 8;
}

/// One picture of a block, little-endian, row by row.
struct GigePart {
  GigeComponent component = GigeComponent::intensity;
  GigePixels pixels = GigePixels::mono8;
  std::vector<std::uint8_t> bytes{};
};

/// What GigE Vision streams at a time (GVSP): one picture, or several of one region.
struct GigeBlock {
  std::uint64_t number = 1;  ///< from 1; of one picture alone at most 65535
  std::chrono::nanoseconds time{};
  Rectangle region{};
  bool is_multipart = false;
  std::size_t packet_bytes = 0;  ///< of GigeStream
  std::vector<GigePart> parts{};
};

/// Of a leader, the pictures' bytes and a trailer.
std::size_t packet_count(const GigeBlock& block);
/// Into `packet`, whose memory is used; `place` is below packet_count().
void write_packet(const GigeBlock& block, std::size_t place, std::vector<std::uint8_t>& packet);
/// Likewise the answer where a block's packet is asked for that there is no more.
void write_missing_packet(const GigeResend& asked, std::vector<std::uint8_t>& packet);

/// The region of a picture, which it is within, taken now.
GigeBlock block_of(const Image<std::uint8_t>& picture, const GigeStream& stream,
                   std::uint16_t number);
void for_each_packet(const GigeBlock& block,
                     const std::function<void(std::span<const std::uint8_t>)>& send);

}  // namespace slipstream
