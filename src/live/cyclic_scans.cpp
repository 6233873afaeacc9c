#include "live/cyclic_scans.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/throw_if-inl.h"
#include "decode/frame_adapter.h"

namespace slipstream {

CyclicScans::CyclicScans(FrameSource& source, const Sequence& sequence, int scans)
    : source_(source),
      frames_(frame_count(sequence)),
      scans_(scans),
      windows_(pattern_cycle(sequence, scans),
               sequence.marker ? PatternIndexing::marker : PatternIndexing::source,
               source.format().size),
      pool_(static_cast<std::size_t>(kept_cycles * (frames_ * scans_ + 1)),
            [&] { return Frame(source.format()); }) {
  throw_if(scans > 1 && sequence.motion > 0,
           "scans along both axes require a still scene; leave out `motion`");
}

std::optional<Glimpse> CyclicScans::look(std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  do {
    // 1. Take a frame, at most 50 ms at a time so that the time limit is kept.
    Pooled<Frame> frame = pool_.take();
    if (!frame) throw Error("out of frame buffers before a cycle was complete");
    const Arrival arrival =
        source_.next(frame.fill(), std::min(timeout, std::chrono::milliseconds(50)));

    if (arrival == Arrival::ended) {
      throw WorldError(fmt::format(
          "the frames ended before a second complete cycle of {}; it takes two to detect motion",
          frames_ * scans_));
    }
    if (arrival != Arrival::frame) continue;

    // 2. Go on until it completes a cycle from the first pattern on that shares no frame with the
    // last one.
    windows_.put(frame);
    frame = {};
    if (!windows_.next(window_) || windows_.first_pattern() != 0) continue;

    std::optional<std::vector<FrameSet>> frames = scans_of_window();
    if (!frames) continue;

    // 3. Compare with the last cycle: a still scene gives the same frames.
    const bool still = std::ranges::equal(seen_, *frames, is_still);
    seen_ = std::move(*frames);
    return Glimpse{seen_, still};
  } while (std::chrono::steady_clock::now() < end);

  return std::nullopt;
}

std::optional<std::vector<FrameSet>> CyclicScans::scans_of_window() {
  // Windows overlap, so drop those with a frame of the last look.
  const auto [oldest, newest] = std::ranges::minmax_element(
      window_, {}, [](const auto& frame) { return frame->stamp.sequence; });
  if (newest_ && (*oldest)->stamp.sequence <= *newest_) return std::nullopt;
  newest_ = (*newest)->stamp.sequence;

  std::vector<FrameSet> scans;
  for (auto first = window_.begin(); first != window_.end(); first += frames_) {
    std::vector<Frame> frames;
    for (int n = 0; n < frames_; ++n) frames.push_back(*first[n]);
    scans.push_back(frame_set_of(std::move(frames)));
  }

  return scans;
}

std::optional<std::vector<FrameSet>> CyclicScans::take() {
  if (seen_.empty()) return std::nullopt;
  return seen_;
}

FrameSet take_window(FrameSource& frames, const Sequence& sequence, const std::string& source) {
  frames.start();
  std::optional<Glimpse> seen = CyclicScans(frames, sequence, 1).look(std::chrono::seconds(10));
  frames.stop();

  if (seen) return std::move(seen->frames.front());
  throw WorldError(
      fmt::format("{}: no complete cycle of {} frames arrived", source, cycle_length(sequence)));
}

}  // namespace slipstream
