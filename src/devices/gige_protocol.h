#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <netinet/in.h>

#include "slipstream/image.h"

namespace slipstream {

/// 32-bit registers of a GigE Vision camera, from the standard or from our camera description.
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
  // of Line0; see line_register
  line_mode = 0x340,      ///< 1: output
  line_source = 0x344,    ///< 1: exposure active; 2: timer
  line_inverter = 0x348,  ///< 1: low while active
  timer_source = 0x380,
  timer_delay = 0x384,     ///< us
  timer_duration = 0x388,  ///< us
  temperature = 0x390,     ///< of the sensor, degrees Celsius; four bytes on, of the mainboard
  // defined by the standard
  heartbeat_timeout = 0x938,  ///< ms; clamped to half a second to a minute
  control_privilege = 0xa00,
  stream_port = 0xd00,
  packet_size = 0xd04,
  packet_delay = 0xd08,  ///< ticks of the camera's clock
  stream_host = 0xd18,
  stream_configuration = 0xd24,
};

/// The register of another line than Line0.
constexpr GigeRegister line_register(GigeRegister of_line_0, int line) {
  return static_cast<GigeRegister>(static_cast<int>(of_line_0) + 0x10 * line);
}

/// Stream settings requested by the client.
struct GigeStream {
  sockaddr_in to;
  Rectangle region;          ///< within the sensor
  std::size_t packet_bytes;  ///< pixel bytes per packet, at least 1
  std::chrono::microseconds period;
  std::chrono::nanoseconds packet_delay;  ///< minimum delay between packets
  bool is_free, is_triggered;             ///< free-running; no longer waits for a trigger
};

/// Packets of a block that the client has not received.
struct GigeResend {
  std::uint64_t block = 0;
  std::size_t first = 0, last = 0;
  bool long_numbers = false;  ///< as in multi-part blocks
};

/// Status of an answer.
enum class GigeStatus : std::uint16_t {
  success = 0,
  not_implemented = 0x8001,
  invalid_parameter = 0x8002,
  invalid_address = 0x8003,
  write_protected = 0x8004,
  access_denied = 0x8006,
};

/// The control channel of a GigE Vision camera (GVCP), without a socket: registers, the description
/// after them, and the single client that may write. Packets are untrusted.
class GigeControl {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// The address range a client may write, end excluded.
  using Writable = std::vector<std::pair<std::size_t, std::size_t>>;
  /// Whether a register may take a value; called before it is set.
  using Accept = std::function<GigeStatus(GigeRegister, std::uint32_t)>;

  /// `memory`: 64 KiB of registers, then the read-only description. `writable`: by default Aravis'
  /// fake camera's registers except name and sensor.
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

  /// The answer to a packet, or empty. A client keeps control until it releases it or is silent for
  /// its own timeout; then the registers are reset to their state before it.
  std::vector<std::uint8_t> answer(std::span<const std::uint8_t> packet, const sockaddr_in& from,
                                   Time now);
  /// Call before or after reading the sockets, several times a second. From the first call on, a
  /// client's silence is only time with such calls: while this program stalls, its packets wait.
  void listen(Time now);
  /// nullopt unless a client has started a stream to its own address with a region on the sensor.
  std::optional<GigeStream> stream(Time now);
  /// The client's stream destination, at its own address.
  [[nodiscard]] std::optional<sockaddr_in> stream_target() const;
  /// The latest resend request since the last call.
  std::optional<GigeResend> take_resend() { return std::exchange(resend_, std::nullopt); }
  /// Number of clients whose control has ended.
  std::uint64_t ended_controls(Time now) {
    forget_silent_client(now);
    return ended_controls_;
  }
  /// Number of clients that lost control by silence.
  [[nodiscard]] std::uint64_t silent_clients() const { return silent_clients_; }

  [[nodiscard]] const std::vector<std::uint8_t>& memory() const { return memory_; }
  [[nodiscard]] std::uint32_t read(GigeRegister which) const;
  /// Sets a register now and as its value after a client leaves.
  void write(GigeRegister which, std::uint32_t value);
  /// Sets a register until the client leaves.
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
  Time heard_;  ///< the client's
  std::optional<Time> listened_;
  std::optional<GigeResend> resend_;
  std::uint64_t silent_clients_ = 0, ended_controls_ = 0;
};

/// Content of a picture, numbered as in GenICam.
enum class GigeComponent : std::uint16_t { intensity = 1, range = 4, confidence = 6 };

/// Pixel format, numbered as in GenICam (PFNC).
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

/// One streamed block (GVSP): a picture, or several of one region.
struct GigeBlock {
  std::uint64_t number = 1;  ///< from 1; at most 65535 if it has a single picture
  std::chrono::nanoseconds time{};
  Rectangle region{};
  bool is_multipart = false;
  std::size_t packet_bytes = 0;  ///< see GigeStream
  std::vector<GigePart> parts{};
};

/// Counts the leader, the pictures' packets and the trailer.
std::size_t packet_count(const GigeBlock& block);
/// Writes a packet into `packet`, reusing its memory; `place` is below packet_count().
void write_packet(const GigeBlock& block, std::size_t place, std::vector<std::uint8_t>& packet);
/// Writes the answer to a resend request for a packet that is no longer available.
void write_missing_packet(const GigeResend& request, std::vector<std::uint8_t>& packet);

/// A region within a picture, timestamped now.
GigeBlock block_of(const Image<std::uint8_t>& picture, const GigeStream& stream,
                   std::uint16_t number);
void for_each_packet(const GigeBlock& block,
                     const std::function<void(std::span<const std::uint8_t>)>& send);

}  // namespace slipstream
