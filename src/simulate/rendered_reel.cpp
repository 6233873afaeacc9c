#include "simulate/rendered_reel.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <vector>

#include "base/thread_priority.h"
#include "base/throw_if-inl.h"
#include "simulate/looped_scene.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {
namespace {

FrameFormat format_of(const ReelScript& script) {
  require_valid(script.scanner);
  require_valid(script.photometry);
  throw_if(!script.photometry.bits, "a virtual camera has 8 to 16 bits; none are given");
  throw_if(script.order.empty(), "a virtual camera without frames; expected at least one");
  return {script.scanner.camera.size, *script.photometry.bits};
}

/// Calls `take` with each frame and its index, until `stopped` says true. Traces the rays for
/// the first frame, and again only if the scene moves within an exposure.
void render(const ReelScript& script, const Moment& moment, const std::function<bool()>& stopped,
            const std::function<void(std::size_t, Frame)>& take) {
  std::optional<VirtualScan> seen;
  for (const std::size_t k : moment.frames) {
    const PatternSet& pattern = script.cycle[script.patterns[k]];
    Photometry light = script.photometry;
    light.seed += k;

    Frame frame;
    // Frames of one moment share the rays of the first.
    if (seen) {
      frame = first_frame(take_again(*seen, pattern, light));
    } else {
      seen = take_scan(script.scanner, moment.scene, pattern, light, moment.time, stopped);
      frame = first_frame(seen->frames);
    }

    frame.stamp.sequence = k;
    frame.stamp.pattern_index = static_cast<int>(script.patterns[k]);

    if (stopped()) return;
    take(k, std::move(frame));
  }
}

}  // namespace

Reel rendered(const ReelScript& script) {
  static_cast<void>(format_of(script));
  Reel reel{.frames = std::vector<Frame>(script.patterns.size()),
            .order = script.order,
            .enough = script.enough};
  for (const Moment& moment : script.moments) {
    render(
        script, moment, [] { return false; },
        [&](std::size_t k, Frame frame) { reel.frames[k] = std::move(frame); });
  }

  return reel;
}

RenderedReel::RenderedReel(ReelScript script, std::function<void(double)> progress)
    : format_(format_of(script)),
      order_(script.order),
      holds_(script.holds),
      hold_length_(script.hold_length),
      loop_from_(script.loop_from),
      enough_(script.enough),
      frames_(script.patterns.size()),
      is_rendered_(script.patterns.size(), false) {
  // Renders in the background; a failure is kept for the reader to receive.
  thread_ = std::thread([this, script = std::move(script), progress = std::move(progress)] {
    let_others_go_first();
    try {
      render(script, progress);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      failure_ = std::current_exception();
    }

    changed_.notify_all();
  });
}

RenderedReel::RenderedReel(Reel reel)
    : order_(std::move(reel.order)),
      enough_(reel.enough),
      frames_(std::move(reel.frames)),
      is_rendered_(frames_.size(), true) {
  throw_if(frames_.empty(), "a virtual camera needs at least one frame");

  format_ = frames_.front().format();
  for (const Frame& frame : frames_) {
    throw_if(frame.format() != format_,
             "a virtual camera with frames of several sizes or bits; all must have one format");
  }
}

RenderedReel::~RenderedReel() {
  ending_ = true;
  if (thread_.joinable()) thread_.join();
}

void RenderedReel::render(const ReelScript& script, const std::function<void(double)>& progress) {
  std::size_t count = 0;
  // A frame is in place before it is marked as rendered.
  const auto take = [&](std::size_t k, Frame frame) {
    frames_[k] = std::move(frame);
    const std::lock_guard lock(mutex_);
    is_rendered_[k] = true;
    changed_.notify_all();
  };

  const auto stopped = [this] { return ending_.load(); };
  for (const Moment& moment : script.moments) {
    slipstream::render(script, moment, stopped, take);
    if (ending_) return;
    count += moment.frames.size();
    if (progress) {
      progress(static_cast<double>(count) / static_cast<double>(script.patterns.size()));
    }
  }
}

bool RenderedReel::is_rendered(std::size_t position) const {
  return is_rendered_[order_[position]];
}

const Frame* RenderedReel::at(std::size_t position) const {
  const std::lock_guard lock(mutex_);
  if (is_rendered(position)) return &frames_[order_[position]];
  if (failure_) std::rethrow_exception(failure_);
  return nullptr;
}

bool RenderedReel::wait_for(std::size_t position, Clock::time_point until) const {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, until, [&] { return is_rendered(position) || failure_; });
  if (!is_rendered(position) && failure_) std::rethrow_exception(failure_);
  return is_rendered(position);
}

bool RenderedReel::has(std::size_t first, std::size_t last) const {
  const std::lock_guard lock(mutex_);
  while (first < last && is_rendered(first)) ++first;
  return first == last;
}

void ReelPlayer::advance(std::size_t frames) {
  const std::vector<std::size_t>& holds = reel_->holds();
  const std::size_t length = reel_->hold_length(), end = reel_->order().size();

  // Whole loops lead back to the same frame.
  if (frames > end) frames = end + (frames - end) % (end - reel_->loop_from());

  for (std::size_t i = 0; i < frames; ++i) {
    has_passed_enough_ |= is_last_needed();
    ++position_;

    // 1. After resting cycles: go on only if the scene can reach its next rest, or the end.
    const auto next = std::ranges::lower_bound(holds, position_);
    const bool was_resting = next != holds.begin() && *std::prev(next) + length == position_;
    if (was_resting) {
      const std::size_t until = next == holds.end() ? end : *next + length;
      if (!reel_->has(position_, until)) position_ -= length;
    }

    // 2. From the end back to the beginning of the loop.
    if (position_ == end) position_ = reel_->loop_from();
  }
}

bool ReelPlayer::is_last_needed() const {
  const std::size_t end = reel_->order().size();
  return position_ + 1 == (reel_->enough() > 0 ? reel_->enough() : end);
}

}  // namespace slipstream
