#include "slipstream/live/cyclic_scans.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/decode/frame_adapter.h"

namespace slipstream {
namespace {

/// As many cycles as PatternWindows may keep frames of.
constexpr int kept_cycles = 4;

}  // namespace

CyclicScans::CyclicScans(FrameSource& source, const Sequence& sequence, int scans)
    : source_(source),
      frames_(frame_count(sequence)),
      scans_(scans),
      windows_(pattern_cycle(sequence, scans),
               sequence.marker ? PatternIndexing::marker : PatternIndexing::told,
               source.format().size),
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
  const auto [oldest, newest] = std::minmax_element(
      window.begin(), window.end(),
      [](const auto& a, const auto& b) { return a->stamp.sequence < b->stamp.sequence; });
  if (newest_ && (*oldest)->stamp.sequence <= *newest_) return std::nullopt;
  newest_ = (*newest)->stamp.sequence;
  std::vector<FrameSet> scans;
  for (auto first = window.begin(); first != window.end(); first += frames_) {
    std::vector<Frame> frames;
    std::transform(first, first + frames_, std::back_inserter(frames),
                   [](const Pooled<Frame>& frame) { return *frame; });
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
      fmt::format("{}: no whole cycle of {} frames came", source, cycle_length(sequence)));
}

FrameSet joined(const std::vector<FrameSet>& sets) {
  if (sets.empty()) return {};
  return sets.front().visit([&]<class Pixel>(const Frames<Pixel>&) {
    std::vector<Image<Pixel>> images;
    for (const FrameSet& set : sets) {
      set.visit([&]<class Other>(const Frames<Other>& views) {
        if constexpr (std::is_same_v<Pixel, Other>) {
          for (const auto& view : views) {
            Image<Pixel>& image = images.emplace_back(view.size());
            std::copy_n(view.row(0), image.pixel_count(), image.begin());
          }
        } else {
          throw Error("frames of several formats cannot be merged");
        }
      });
    }
    if constexpr (std::is_same_v<Pixel, std::uint16_t>) {
      return FrameSet(std::move(images), sets.front().bits());
    } else {
      return FrameSet(std::move(images));
    }
  });
}

}  // namespace slipstream
