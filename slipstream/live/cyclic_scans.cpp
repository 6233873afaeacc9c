#include "slipstream/live/cyclic_scans.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

/// As many cycles as PatternWindows may keep frames of.
constexpr int kept_cycles = 4;

}  // namespace

CyclicScans::CyclicScans(FrameSource& source, const Sequence& sequence, int scans)
    : source_(source),
      frames_(frame_count(sequence)),
      scans_(scans),
      windows_(sequence, sequence.marker ? PatternIndexing::marker : PatternIndexing::told,
               source.format().size, scans),
      pool_(static_cast<std::size_t>(kept_cycles * (frames_ * scans_ + 1)),
            [&] { return Frame(source.format()); }) {
  if (scans > 1 && sequence.motion > 0) {
    throw Error("scans along both axes are of what stands still; leave out --motion");
  }
}

std::optional<Glimpse> CyclicScans::look(std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  do {
    Pooled<Frame> frame = pool_.take();
    if (!frame) throw Error("more frames of a cycle wait than can be");
    const Arrival arrival =
        source_.next(frame.fill(), std::min(timeout, std::chrono::milliseconds(50)));
    if (arrival == Arrival::ended) {
      throw WorldError(fmt::format(
          "the frames ended before a second whole cycle of {} came, to see that nothing moves",
          frames_ * scans_));
    }
    if (arrival != Arrival::frame) continue;
    windows_.put(frame);
    frame = {};
    if (!windows_.next(window_) || windows_.first_pattern() != 0) continue;
    std::optional<std::vector<FrameSet>> frames = cycle_of(window_);
    if (!frames) continue;
    const bool still =
        std::equal(seen_.begin(), seen_.end(), frames->begin(), frames->end(),
                   [](const FrameSet& a, const FrameSet& b) { return is_still(a, b); });
    seen_ = std::move(*frames);
    return Glimpse{seen_, still};
  } while (std::chrono::steady_clock::now() < end);
  return std::nullopt;
}

std::optional<std::vector<FrameSet>> CyclicScans::cycle_of(
    const std::vector<Pooled<Frame>>& window) {
  std::uint64_t oldest = window.front()->stamp.sequence, newest = oldest;
  for (const Pooled<Frame>& frame : window) {
    oldest = std::min(oldest, frame->stamp.sequence);
    newest = std::max(newest, frame->stamp.sequence);
  }
  if (newest_ && oldest <= *newest_) return std::nullopt;
  newest_ = newest;
  std::vector<FrameSet> scans;
  for (int scan = 0; scan < scans_; ++scan) {
    std::vector<Frame> frames;
    for (int n = 0; n < frames_; ++n) {
      frames.push_back(*window[static_cast<std::size_t>(scan * frames_ + n)]);
    }
    scans.push_back(frame_set_of(std::move(frames)));
  }
  return scans;
}

std::optional<std::vector<FrameSet>> CyclicScans::take() {
  if (seen_.empty()) return std::nullopt;
  return seen_;
}

}  // namespace slipstream
