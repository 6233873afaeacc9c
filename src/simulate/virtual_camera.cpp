#include "slipstream/virtual_camera.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "base/throw_if-inl.h"
#include "simulate/looped_scene.h"
#include "simulate/rendered_reel.h"

namespace slipstream {

std::vector<Frame> virtual_frames(const Scanner& scanner, const Scene& scene,
                                  const PatternSet& patterns, const Photometry& photometry,
                                  int cycles) {
  return rendered(looped_scene(scanner, scene, patterns, photometry, cycles)).frames;
}

VirtualCamera::VirtualCamera(std::shared_ptr<const RenderedReel> reel, std::optional<double> rate)
    : player_(std::make_unique<ReelPlayer>(std::move(reel))), rate_(rate) {
  if (rate_ && !(*rate_ > 0 && std::isfinite(*rate_))) {
    throw Error(fmt::format("frame rate {} Hz is out of range; expected above 0", *rate_));
  }
}

VirtualCamera::VirtualCamera(Reel reel, std::optional<double> rate)
    : VirtualCamera(std::make_shared<RenderedReel>(std::move(reel)), rate) {}

VirtualCamera::VirtualCamera(std::vector<Frame> loop, std::optional<double> rate)
    : VirtualCamera(reel_of(std::move(loop)), rate) {}

VirtualCamera::~VirtualCamera() = default;

FrameFormat VirtualCamera::format() const {
  return player_->reel().format();
}

void VirtualCamera::start() {
  start_ = pace_start_ = Clock::now();
  sequence_ = 0;
  is_late_ = false;
  player_->restart();
}

std::optional<VirtualCamera::Clock::time_point> VirtualCamera::wait_until(Clock::time_point end) {
  const Clock::time_point now = Clock::now();
  if (!rate_) return now;
  const double taken = std::chrono::duration<double>(now - pace_start_).count() * *rate_;
  const double behind = std::floor(taken) - static_cast<double>(sequence_) - waiting_frames;

  // Frames that no longer fit into the buffer are lost.
  if (behind > 0) {
    sequence_ += static_cast<std::uint64_t>(behind);
    lost_ += static_cast<std::uint64_t>(behind);
    player_->advance(static_cast<std::size_t>(behind));
  }

  const std::chrono::duration<double> due(static_cast<double>(sequence_ + 1) / *rate_);
  const Clock::time_point whole = pace_start_ + std::chrono::duration_cast<Clock::duration>(due);

  // A sleep may end early by a tick of the system's clock.
  while (Clock::now() < std::min(whole, end)) std::this_thread::sleep_until(std::min(whole, end));

  if (whole > end) return std::nullopt;
  return whole;
}

Arrival VirtualCamera::next(Frame& frame, std::chrono::milliseconds timeout) {
  const Clock::time_point end = Clock::now() + timeout;

  // 1. Rendered late, a frame comes late; the camera's pace goes on from it.
  is_late_ |= player_->frame() == nullptr;
  if (is_late_) {
    if (!player_->wait_for_frame(end)) return Arrival::nothing;
    if (rate_) {
      const std::chrono::duration<double> before(static_cast<double>(sequence_) / *rate_);
      pace_start_ = Clock::now() - std::chrono::duration_cast<Clock::duration>(before);
    }
    is_late_ = false;
  }

  // 2. The frame that is due: after losses not the one above.
  const auto whole = wait_until(end);
  if (!whole) return Arrival::nothing;
  const Frame* const seen = player_->frame();
  if (seen == nullptr) return Arrival::nothing;

  frame = *seen;
  frame.stamp = {.sequence = sequence_++,
                 .pattern_index = seen->stamp.pattern_index,
                 .device_time = *whole - start_,
                 .host_time = *whole};
  player_->advance();
  ++delivered_;
  return Arrival::frame;
}

}  // namespace slipstream
