#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <random>
#include <stdexcept>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/fuzz/mutate.h"

namespace slipstream {

inline constexpr std::uint16_t discover = 0x02, read_register = 0x80, write_register = 0x82,
                               read_memory = 0x84, write_memory = 0x86;

inline constexpr std::uint32_t loopback = 0x7f000001;

inline sockaddr_in address_of(std::uint32_t host, std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(host);
  return address;
}

inline constexpr std::uint16_t camera_port = 3956;

/// A UDP client socket on any free port of an address.
class ClientSocket {
 public:
  explicit ClientSocket(std::uint32_t host = loopback) {
    const sockaddr_in at = address_of(host, 0);
    const int failed = ::bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof(at));
    if (failed != 0) throw std::runtime_error("no port is free");
  }
  ClientSocket(const ClientSocket&) = delete;
  ClientSocket& operator=(const ClientSocket&) = delete;
  ~ClientSocket() { ::close(socket_); }

  void send(const Bytes& packet, std::uint16_t port = camera_port) const {
    const sockaddr_in to = address_of(loopback, port);
    ::sendto(socket_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to),
             sizeof(to));
  }
  /// Returns the next packet; empty on timeout.
  [[nodiscard]] Bytes receive(std::chrono::milliseconds patience = std::chrono::seconds(2)) const {
    const timeval wait{.tv_sec = patience.count() / 1000,
                       .tv_usec = patience.count() % 1000 * 1000};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof(wait));
    Bytes packet(65536);
    packet.resize(static_cast<std::size_t>(
        std::max<ssize_t>(0, ::recv(socket_, packet.data(), packet.size(), 0))));
    return packet;
  }
  [[nodiscard]] std::uint16_t port() const {
    sockaddr_in at{};
    socklen_t length = sizeof(at);
    ::getsockname(socket_, reinterpret_cast<sockaddr*>(&at), &length);
    return ntohs(at.sin_port);
  }

 private:
  int socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

/// A GVCP command that requests an acknowledgement.
inline Bytes command(std::uint16_t code, std::initializer_list<std::uint32_t> numbers,
                     std::uint16_t id = 7) {
  Bytes bytes{0x42, 1};
  const auto append = [&](std::uint32_t number, int size) {
    while (size-- > 0) bytes.push_back(static_cast<std::uint8_t>(number >> (8 * size)));
  };
  append(code, 2);
  append(static_cast<std::uint32_t>(4 * numbers.size()), 2);
  append(id, 2);
  for (const std::uint32_t number : numbers) append(number, 4);
  return bytes;
}

/// A packet that could crash a camera: extreme numbers, zero or excessive lengths, damaged commands
/// or noise.
inline Bytes hostile_packet(std::mt19937& random) {
  static constexpr std::array<std::uint32_t, 12> edges{0,       0x100,      0x200,      0x938,
                                                       0xa00,   0xd00,      0xfffc,     0x10000,
                                                       0x13e66, 0x7fffffff, 0xfffffffc, 0xffffffff};
  const auto number = [&] {
    const auto noise = static_cast<std::uint32_t>(random());
    return noise % 4 == 0 ? noise : edges[noise % edges.size()] + (noise >> 16) % 9 - 4;
  };
  static constexpr std::array<std::uint16_t, 7> codes{
      discover, read_register, write_register, read_memory, write_memory, 0x40, 0x88};
  const std::uint16_t code = codes[random() % codes.size()];
  const auto id = static_cast<std::uint16_t>(random());
  switch (random() % 6) {
    case 0:
      return command(code, {number()}, id);
    case 1:
      return command(code, {number(), number()}, id);
    case 2:
      return command(code, {number(), number(), number()}, id);
    case 3: {
      Bytes noise(random() % 1500);
      for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random());
      return noise;
    }
    default:
      return mutated(command(code, {number(), number()}, id), random);
  }
}

}  // namespace slipstream
