#pragma once

#include <atomic>
#include <mutex>
#include <random>
#include <stop_token>
#include <thread>

#include "slipstream/devices/gige_protocol.h"
#include "slipstream/devices/gige_sockets.h"
#include "slipstream/frames/frame_source.h"

namespace slipstream {

/// A GigE Vision camera served over UDP to any client: Mono8, with the client's rate, region and
/// trigger. Frames are numbered from 1 when a client starts the stream; frame k shows frame (k - 1)
/// mod length of a reel, also after losses. With several reels, clients see the first until one has
/// seen enough of it, then the next, and so on.
class VirtualGigeCamera {
 public:
  /// `reels`: not empty, 8-bit frames of one size. `address`: of a network interface of this
  /// machine, one camera each. `serial`: name shown to clients, 1 to 15 letters. Throws Error if
  /// violated, WorldError if no interface has the address or its port 3956 is taken.
  VirtualGigeCamera(std::vector<Reel> reels, const std::string& address, const std::string& serial);
  /// One reel in which each frame is shown once.
  VirtualGigeCamera(std::vector<Frame> loop, const std::string& address, const std::string& serial)
      : VirtualGigeCamera(std::vector<Reel>{reel_of(std::move(loop))}, address, serial) {}
  ~VirtualGigeCamera() = default;  ///< disappears without notifying its client

  /// Frame rate until a client changes it, 0.001 to 1e6 Hz.
  void set_frame_rate(double rate);
  /// Drops this share of packets, 0 to 1.
  void set_packet_loss(double share) { packet_loss_ = share; }
  /// Frames sent to all clients since the start.
  [[nodiscard]] std::uint64_t sent() const { return sent_; }

 private:
  const Image<std::uint8_t>& picture(std::size_t k);
  void send(const GigeStream& stream, std::size_t k);
  void run(const std::stop_token& stop);

  const std::vector<Reel> reels_;
  const GigeControlSockets control_sockets_;
  const UdpSocket stream_socket_;
  std::mutex mutex_;  ///< guards control_
  GigeControl control_;
  std::size_t reel_ = 0;     ///< the reel shown to the client
  bool seen_whole_ = false;  ///< by this client or an earlier one
  std::atomic<double> packet_loss_ = 0;
  std::atomic<std::uint64_t> sent_ = 0;
  std::minstd_rand random_;
  std::jthread thread_;  ///< uses the members above; destroyed first
};

}  // namespace slipstream
