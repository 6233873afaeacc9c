#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "devices/gige_protocol.h"
#include "devices/gige_sockets.h"
#include "simulate/rendered_reel.h"

namespace slipstream {

/// How the virtual projector is connected to the virtual camera's Line1. Its first pattern is the
/// first after a client starts the stream.
enum class Wiring {
  in_step,  ///< without a wire each frame shows the next pattern
  trigger,  ///< the projector shows patterns at its own rate; each sends a pulse to Line1
  strobe,   ///< the projector advances at each rising edge from Line1
};

/// "in-step", "trigger" or "strobe"; throws Error for other names.
Wiring wiring_named(std::string_view name);

/// A GigE Vision camera served over UDP to any client: Mono8, with the client's rate, region,
/// trigger and output lines. Frames are numbered from 1 when a client starts the stream; wired in
/// step, frame k shows frame (k - 1) mod length of a reel, also after losses; while the reel is
/// being rendered, a ReelPlayer says which. With several reels, clients see the first until one has
/// seen enough of it, then the next, and so on.
class VirtualGigeCamera {
 public:
  using Reels = std::vector<std::shared_ptr<const RenderedReel>>;

  /// `reels`: not empty, 8-bit frames of one size. `address`: of a network interface of this
  /// machine, one camera each. `serial`: name shown to clients, 1 to 15 letters. Throws Error if
  /// violated, WorldError if no interface has the address or its port 3956 is taken.
  VirtualGigeCamera(Reels reels, const std::string& address, const std::string& serial);
  /// One reel in which each frame is shown once.
  VirtualGigeCamera(std::vector<Frame> loop, const std::string& address, const std::string& serial)
      : VirtualGigeCamera(Reels{std::make_shared<RenderedReel>(reel_of(std::move(loop)))}, address,
                          serial) {}
  ~VirtualGigeCamera();  ///< disappears without notifying its client

  /// Frame rate until a client changes it, and the projector's pattern rate, 0.001 to 1e6 Hz.
  void set_frame_rate(double rate);
  void set_wiring(Wiring wiring) { wiring_ = wiring; }
  /// Sends what `view` returns, called for each frame from another thread, in place of the reels.
  /// Call before a client connects.
  void look_at(std::function<Image<std::uint8_t>()> view) { view_ = std::move(view); }
  /// Drops this share of packets, 0 to 1.
  void set_packet_loss(double share) { packet_loss_ = share; }
  /// Frames sent to all clients since the start.
  [[nodiscard]] std::uint64_t sent() const { return sent_; }

 private:
  [[nodiscard]] std::size_t shown_in(std::size_t k) const;
  [[nodiscard]] bool has_picture() const;
  void begin_reel();
  const Image<std::uint8_t>* picture(std::size_t shown);
  void send(const GigeStream& stream, std::size_t k, std::size_t shown);
  void run();

  const Reels reels_;
  const GigeControlSockets control_sockets_;
  const UdpSocket stream_socket_;
  std::mutex mutex_;  ///< guards control_
  GigeControl control_;
  std::function<Image<std::uint8_t>()> view_;
  std::size_t reel_ = 0;  ///< the reel shown to the client
  ReelPlayer player_{reels_.front()};
  std::size_t player_shows_ = 0;  ///< frames shown since the client's start, in step with player_
  bool seen_whole_ = false;       ///< by this client or an earlier one
  std::atomic<Wiring> wiring_ = Wiring::in_step;
  std::chrono::microseconds projector_period_{10'000};  ///< guarded by mutex_
  std::chrono::steady_clock::time_point started_;       ///< of the stream
  std::size_t pulses_ = 0;                              ///< from Line1 since then
  std::atomic<double> packet_loss_ = 0;
  std::atomic<std::uint64_t> sent_ = 0;
  std::minstd_rand random_;
  std::atomic<bool> is_ending_ = false;
  std::thread thread_;  ///< uses the members above
};

}  // namespace slipstream
