#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <netinet/in.h>

namespace slipstream {

/// Parses "127.0.0.1"; throws Error if it is not an IPv4 address.
in_addr host_from(const std::string& address);

class UdpSocket {
 public:
  /// Port 0: any free one. `shared`: other sockets may use the port too. Throws WorldError.
  UdpSocket(in_addr host, std::uint16_t port, bool shared);
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;
  ~UdpSocket();

  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] std::uint16_t port() const;
  /// The next packet; empty if there is none or it is longer than the protocol allows.
  std::vector<std::uint8_t> receive(sockaddr_in& from) const;
  /// Packets that cannot be sent are dropped.
  void send(std::span<const std::uint8_t> packet, const sockaddr_in& to) const;
  /// Sends without fragmentation: packets too long for the network are dropped.
  void send_whole(std::span<const std::uint8_t> packet, const sockaddr_in& to) const;

 private:
  int descriptor_;
};

/// Control port of a GigE Vision camera on this machine: port 3956 of the address, and broadcasts.
class GigeControlSockets {
 public:
  /// Returns the answer to a packet; empty for no answer.
  using Answer =
      std::function<std::vector<std::uint8_t>(std::span<const std::uint8_t>, const sockaddr_in&)>;

  /// Throws Error for an invalid address, WorldError if no interface has it or its port is taken.
  explicit GigeControlSockets(const std::string& address);

  /// Answers at most one packet per socket, so that a flood of packets blocks nothing. Waits less
  /// than a second for the first. Broadcasts only get a discovery answer.
  void answer(std::chrono::nanoseconds longest_wait, const Answer& answer) const;

 private:
  GigeControlSockets(in_addr host, in_addr broadcast);

  std::array<UdpSocket, 3> sockets_;  ///< the first belongs to the camera's own address
};

/// This process's IPv4 UDP sockets, and the addresses that they are bound to.
std::vector<std::pair<int, sockaddr_in>> udp_sockets();

/// Source and destination of a GigE Vision camera's stream.
struct PictureStream {
  std::uint16_t port = 0;           ///< port of a UDP socket of this process
  std::uint32_t camera = 0;         ///< the camera's IPv4 address, in host byte order
  std::uint32_t packet_size = 0;    ///< packet size on the wire with all headers, 100 or more
  std::uint32_t picture_bytes = 0;  ///< size of the receiving buffers
};

/// Makes the kernel pass only picture packets of this camera with valid packet numbers to the
/// socket: Aravis 0.8.26 accepts packets of any sender, writes past its buffers if numbers are too
/// large, and trusts the sizes of other payloads. Returns false if the socket does not exist.
bool pass_pictures_only(const PictureStream& stream);

}  // namespace slipstream
