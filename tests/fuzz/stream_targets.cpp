// Packets of a camera's stream: the kernel's filter before Aravis, by the kernel itself.
#include <array>

#include <sys/socket.h>
#include <unistd.h>

#include "devices/gige_protocol.h"
#include "devices/gige_sockets.h"
#include "tests/devices/gvcp_packets.h"
#include "tests/fuzz/target.h"

namespace slipstream {
namespace {

/// Sends to itself.
class Mirror {
 public:
  Mirror() {
    address_ = address_of(loopback, 0);
    socklen_t size = sizeof(address_);
    auto* const address = reinterpret_cast<sockaddr*>(&address_);
    works_ = ::bind(socket_, address, size) == 0 && ::getsockname(socket_, address, &size) == 0 &&
             passes(Bytes(1));
  }
  Mirror(const Mirror&) = delete;
  Mirror& operator=(const Mirror&) = delete;
  ~Mirror() { ::close(socket_); }

  /// Not where the machine has no network.
  [[nodiscard]] bool works() const { return works_; }
  [[nodiscard]] std::uint16_t port() const { return ntohs(address_.sin_port); }
  [[nodiscard]] bool passes(std::span<const std::uint8_t> packet) const {
    const auto sent = static_cast<std::size_t>(
        ::sendto(socket_, packet.data(), packet.size(), 0,
                 reinterpret_cast<const sockaddr*>(&address_), sizeof(address_)));
    std::array<std::uint8_t, 1 << 16> received{};
    return sent == packet.size() &&
           ::recv(socket_, received.data(), received.size(), MSG_DONTWAIT) >= 0;
  }

 private:
  int socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address_{};
  bool works_ = false;
};

std::uint32_t big_endian(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t size) {
  std::uint32_t number = 0;
  for (std::size_t i = at; i < at + size; ++i) number = number << 8 | bytes[i];
  return number;
}

/// Whether it belongs to pictures of that stream, as the standard has it.
bool is_of_pictures(std::span<const std::uint8_t> packet, const PictureStream& stream) {
  constexpr std::size_t internet = 28;  // with UDP
  if (stream.camera != loopback || packet.size() <= 8) return false;
  const bool long_numbers = (packet[4] & 0x80) != 0;
  const std::size_t head = long_numbers ? 20 : 8;
  if (packet.size() <= head) return false;
  const std::uint32_t number = long_numbers ? big_endian(packet, 16, 4) : big_endian(packet, 5, 3);
  const std::size_t each = stream.packet_size - internet - head;
  const std::size_t last = (stream.picture_bytes + each - 1) / each;
  switch (packet[4] & 0x7f) {
    case 1:
      return number <= last + 1 && packet.size() >= head + 36 &&
             big_endian(packet, head + 2, 2) == 1;
    case 2:
      return number <= last + 1;
    case 3:
      return number <= last;
    default:
      return false;
  }
}

/// What a camera may be set to, then what it sends.
void filter_packets(std::span<const std::uint8_t> input) {
  static const Mirror mirror;
  if (!mirror.works()) return;
  InputNumbers numbers(input);
  PictureStream stream{.port = mirror.port(),
                       .camera = numbers.next<std::uint8_t>() < 240 ? loopback : loopback + 1,
                       .packet_size = 100 + numbers.next<std::uint16_t>() % 8901U,
                       .picture_bytes = 1 + numbers.next<std::uint32_t>() % 160'000'000U};
  if (!pass_pictures_only(stream)) throw std::logic_error("the socket takes no filter");
  const auto packet = numbers.rest().first(std::min<std::size_t>(numbers.rest().size(), 9100));
  if (mirror.passes(packet) != is_of_pictures(packet, stream)) {
    throw std::logic_error("a packet that does not belong to the pictures, or that does not pass");
  }
}

/// Of pictures of 64x48 in packets of 1000 bytes, at the ends and in the middle; and one by long
/// numbers.
std::vector<Bytes> stream_packets() {
  Bytes settings{0, 900 & 0xff, 900 >> 8};
  for (const std::uint32_t byte : {64U * 48 - 1, 0U, 0U, 0U}) {
    settings.push_back(static_cast<std::uint8_t>(byte));
  }
  settings[4] = (64 * 48 - 1) >> 8;
  std::vector<Bytes> seeds;
  GigeStream stream{};
  stream.region.size = {64, 48};
  stream.packet_bytes = 1000 - 36;
  for (const bool long_numbers : {false, true}) {
    GigeBlock block = block_of(Image<std::uint8_t>({64, 48}), stream, 1);
    block.is_multipart = long_numbers;
    for_each_packet(block, [&](std::span<const std::uint8_t> packet) {
      seeds.push_back(settings);
      seeds.back().insert(seeds.back().end(), packet.begin(), packet.end());
    });
  }
  return seeds;
}

const bool knows_stream_targets = add_fuzz_target({"gvsp", stream_packets, filter_packets});

}  // namespace
}  // namespace slipstream
