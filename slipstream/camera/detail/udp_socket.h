#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "slipstream/camera/detail/gige_control.h"

namespace slipstream {

/// A bound socket for UDP over IPv4.
class UdpSocket {
 public:
  /// Port 0: any that is free. `shared`: others may have it, too. Throws WorldError where it cannot
  /// be had.
  UdpSocket(UdpAddress address, bool shared);
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;
  ~UdpSocket();

  [[nodiscard]] int descriptor() const { return descriptor_; }
  /// The next packet of at most `room` bytes, which are overwritten; empty where there is none, or
  /// a longer one. Does not wait.
  std::span<const std::uint8_t> receive(std::span<std::uint8_t> room, UdpAddress& from) const;
  /// A packet that cannot be sent is lost.
  void send(std::span<const std::uint8_t> packet, UdpAddress to) const;

 private:
  int descriptor_;
};

}  // namespace slipstream
