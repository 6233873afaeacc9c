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

/// A GigE Vision camera of this machine, over UDP, for any client: Mono8, at the rate, region and
/// trigger that the client asks for. Frames are numbered from 1 when a client starts them; frame k
/// shows the frame at (k - 1) mod its length of a reel, whatever was lost. Clients see the first of
/// several reels until one has seen enough of it, those after that the next, and so on.
class VirtualGigeCamera {
 public:
  /// `reels`: not empty, of 8-bit frames of one size. `address`: of a network interface of this
  /// machine, one camera each. `serial`: its name to clients, up to 15 letters. Throws Error if
  /// these are not so, WorldError if no interface has the address or its port 3956 is taken.
  VirtualGigeCamera(std::vector<Reel> reels, const std::string& address, const std::string& serial);
  /// One reel of frames that each come once.
  VirtualGigeCamera(std::vector<Frame> loop, const std::string& address, const std::string& serial)
      : VirtualGigeCamera(std::vector<Reel>{reel_of(std::move(loop))}, address, serial) {}
  ~VirtualGigeCamera() = default;  ///< gone, without a word to its client

  /// How fast it runs until a client asks for another rate, 0.001 to 1e6 Hz.
  void set_frame_rate(double rate);
  /// Loses that share of the packets, 0 to 1.
  void set_packet_loss(double share) { packet_loss_ = share; }
  /// Frames sent since the start, to all clients.
  [[nodiscard]] std::uint64_t sent() const { return sent_; }

 private:
  const Image<std::uint8_t>& picture(std::size_t k);
  void send(const GigeStream& stream, std::size_t k);
  void run(const std::stop_token& stop);

  const std::vector<Reel> reels_;
  const GigeControlSockets control_sockets_;
  const UdpSocket stream_socket_;
  std::mutex mutex_;  ///< of control_
  GigeControl control_;
  std::size_t reel_ = 0;     ///< that the client sees
  bool seen_whole_ = false;  ///< by it, or one before
  std::atomic<double> packet_loss_ = 0;
  std::atomic<std::uint64_t> sent_ = 0;
  std::minstd_rand random_;
  std::jthread thread_;  ///< uses the rest; goes first
};

}  // namespace slipstream
