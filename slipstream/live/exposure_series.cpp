#include "slipstream/live/exposure_series.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/live/pattern_windows.h"
#include "slipstream/live/window_frames.h"

namespace slipstream {
namespace {

/// Copies.
FrameSet frame_set_of(const FrameViews& frames) {
  return frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    std::vector<Image<Pixel>> images;
    for (const auto& view : views) {
      Image<Pixel>& image = images.emplace_back(view.size());
      for (int row = 0; row < view.height(); ++row) {
        std::copy_n(view.row(row), view.width(), image.row(row));
      }
    }
    if constexpr (std::is_same_v<Pixel, std::uint16_t>) {
      return FrameSet(std::move(images), frames.bits());
    } else {
      return FrameSet(std::move(images));
    }
  });
}

}  // namespace

FrameSet take_window(FrameSource& frames, const Sequence& sequence, const std::string& source) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::seconds patience{10};
  constexpr std::size_t kept_cycles = 4;  // that PatternWindows may keep
  const PatternIndexing indexing =
      sequence.marker ? PatternIndexing::marker : PatternIndexing::told;
  PatternWindows windows(sequence, indexing, frames.format().size);
  Pool<Frame> pool(kept_cycles * static_cast<std::size_t>(cycle_length(sequence)) + 1,
                   [&] { return Frame(frames.format()); });
  std::vector<Pooled<Frame>> window;
  frames.start();
  const Clock::time_point end = Clock::now() + patience;
  while (Clock::now() < end) {
    Pooled<Frame> frame = pool.take();
    if (!frame) break;
    const Arrival arrival = frames.next(frame.fill(), std::chrono::milliseconds(200));
    if (arrival == Arrival::ended) break;
    if (arrival != Arrival::frame) continue;
    windows.put(frame);
    frame = {};
    if (!windows.next(window)) continue;
    frames.stop();
    return frame_set_of(views_of(window));
  }
  frames.stop();
  throw WorldError(
      fmt::format("{}: no whole cycle of {} frames came", source, cycle_length(sequence)));
}

FrameSet joined(std::vector<FrameSet> sets) {
  if (sets.empty()) return {};
  return sets.front().visit([&]<class Pixel>(const Frames<Pixel>&) {
    std::vector<ImageView<const Pixel>> views;
    for (const FrameSet& set : sets) {
      set.visit([&]<class Other>(const Frames<Other>& others) {
        if constexpr (std::is_same_v<Pixel, Other>) {
          views.insert(views.end(), others.begin(), others.end());
        } else {
          throw Error("frames of several formats; all are of one");
        }
      });
    }
    if constexpr (std::is_same_v<Pixel, std::uint16_t>) {
      return frame_set_of(FrameViews(std::move(views), sets.front().bits()));
    } else {
      return frame_set_of(FrameViews(std::move(views)));
    }
  });
}

}  // namespace slipstream
