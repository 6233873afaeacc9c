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

/// "127.0.0.1" as a number; throws Error for what is none.
in_addr host_from(const std::string& address);

/// A socket for UDP.
class UdpSocket {
 public:
  /// Port 0: any. `shared`: others may listen there, too. Throws WorldError.
  UdpSocket(in_addr host, std::uint16_t port, bool shared);
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;
  ~UdpSocket();

  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] std::uint16_t port() const;
  /// The next packet, empty where there is none or one longer than any of the protocol.
  std::vector<std::uint8_t> receive(sockaddr_in& from) const;
  /// A packet that cannot be sent is lost.
  void send(std::span<const std::uint8_t> packet, const sockaddr_in& to) const;
  /// Likewise one that is too long for the network, which is not cut to pieces.
  void send_whole(std::span<const std::uint8_t> packet, const sockaddr_in& to) const;

 private:
  int descriptor_;
};

/// Where a GigE Vision camera of this machine is asked: port 3956 of the address, and broadcasts.
class GigeControlSockets {
 public:
  /// What a packet is answered with; empty: nothing.
  using Answer =
      std::function<std::vector<std::uint8_t>(std::span<const std::uint8_t>, const sockaddr_in&)>;

  /// Throws Error for an invalid address, WorldError if no interface has it or its port is taken.
  explicit GigeControlSockets(const std::string& address);

  /// Answers at most one packet of each socket, so that a flood of them keeps nothing waiting.
  /// Waits less than a second for the first. Who asks all is only told that the camera is there.
  void answer(std::chrono::nanoseconds longest_wait, const Answer& answer) const;

 private:
  GigeControlSockets(in_addr host, in_addr broadcast);

  std::array<UdpSocket, 3> sockets_;  ///< the first is the camera's own
};

/// Where a GigE Vision camera's pictures come from and go to.
struct PictureStream {
  std::uint16_t port = 0;           ///< of a UDP socket of this process
  std::uint32_t camera = 0;         ///< its IPv4 address, in the host's byte order
  std::uint32_t packet_size = 0;    ///< as on the wire, with all its headers: 100 or more
  std::uint32_t picture_bytes = 0;  ///< of the buffers that it goes to
};

/// From now on the kernel hands the socket only the camera's packets of pictures, none with a
/// number beyond them: Aravis 0.8.26 takes packets of any sender, writes past its buffers for
/// numbers too large, and trusts the sizes of other payloads. False if there is no such socket.
bool pass_pictures_only(const PictureStream& stream);

}  // namespace slipstream
