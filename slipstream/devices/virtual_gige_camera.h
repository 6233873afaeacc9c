#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "slipstream/frames/frame_source.h"

namespace slipstream {

/// Serves frames as a GigE Vision camera of this machine does, over UDP, to any client of that
/// protocol: Mono8, at the rate, region and trigger that the client asks for. Frames are numbered
/// from 1 when a client starts them; frame k shows the frame at (k - 1) mod its length of a reel,
/// whatever else was lost on the way. Of several reels a client sees the first until one has seen
/// enough of it; who comes after that the next, and so on to the last.
class VirtualGigeCamera {
 public:
  /// `reels`: not empty, of 8-bit frames of one size. `address`: of a network interface of this
  /// machine, one camera each. `serial`: its name to clients, up to 15 letters. Throws Error where
  /// these are not so, WorldError where the address is none or its port for cameras, 3956, is
  /// taken.
  VirtualGigeCamera(std::vector<Reel> reels, const std::string& address, const std::string& serial);
  /// One reel of frames that each come once.
  VirtualGigeCamera(std::vector<Frame> loop, const std::string& address, const std::string& serial);
  ~VirtualGigeCamera();  ///< gone, without a word to its client
  VirtualGigeCamera(const VirtualGigeCamera&) = delete;
  VirtualGigeCamera& operator=(const VirtualGigeCamera&) = delete;

  /// How fast it runs until a client asks for another rate, 0.001 to 1e6 Hz.
  void set_frame_rate(double rate);
  /// How fast it answers software triggers at most, Hz.
  void set_trigger_rate(double rate);
  /// Loses that share of the packets, 0 to 1.
  void set_packet_loss(double share);
  /// Frames sent since the start, to all clients.
  [[nodiscard]] std::uint64_t sent() const;

 private:
  struct Served;
  std::unique_ptr<Served> served_;
};

}  // namespace slipstream
