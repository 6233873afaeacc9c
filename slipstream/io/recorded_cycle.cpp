#include "slipstream/io/recorded_cycle.h"

#include <algorithm>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/decode/frame_adapter.h"
#include "slipstream/frames/scan_camera.h"

namespace slipstream {
namespace {

/// Cycles that are searched for a whole one, and as many as PatternWindows may keep of them.
constexpr std::uint64_t searched_cycles = 8, kept_cycles = 4;

/// Frames by their places in a recording, the last not among them.
struct Places {
  std::uint64_t first = 0, end = 0;
};

/// The first whole cycle among the frames that are read; where `least` is given, the first that
/// begins there or later, and with the first pattern.
std::optional<FrameSet> cycle_among(const RecordingReader& recording, const Sequence& sequence,
                                    const Places& read, std::optional<std::uint64_t> least = {}) {
  const auto cycle = static_cast<std::uint64_t>(cycle_length(sequence) + sequence.motion);
  PatternWindows windows(pattern_cycle(sequence),
                         sequence.marker ? PatternIndexing::marker : PatternIndexing::told,
                         recording.header().format.size);
  // Frames take their memory when they are read.
  Pool<Frame> pool(std::min(read.end - read.first, kept_cycles * cycle + 1),
                   [] { return Frame(); });
  std::vector<Pooled<Frame>> window;
  for (std::uint64_t n = read.first; n < read.end; ++n) {
    Pooled<Frame> frame = pool.take();
    if (!frame) break;
    if (!recording.read(n, frame.fill())) continue;
    windows.put(frame);
    frame = {};
    if (!windows.next(window) || windows.first_pattern() != 0) continue;
    const auto sequence_of = [](const Pooled<Frame>& placed) { return placed->stamp.sequence; };
    const bool begins_earlier = least && n + 1 < *least + window.size();
    if (begins_earlier || (least && sequence_of(window.front()) > sequence_of(window.back()))) {
      continue;
    }
    std::vector<Frame> frames;  // nobody else reads them any more
    for (Pooled<Frame>& placed : window) frames.push_back(std::move(placed.fill()));
    return frame_set_of(std::move(frames));
  }
  return std::nullopt;
}

/// Where the first pattern is shown first, as the first frame's stamp says; a marker says nothing.
std::uint64_t first_start(const RecordingReader& recording, const Sequence& sequence) {
  Frame frame;
  if (sequence.marker || recording.count() == 0 || !recording.read(0, frame)) return 0;
  const auto cycle = static_cast<std::uint64_t>(cycle_length(sequence));
  const FrameStamp& stamp = frame.stamp;
  const std::uint64_t index = stamp.pattern_index
                                  ? static_cast<std::uint64_t>(std::max(*stamp.pattern_index, 0))
                                  : stamp.sequence;
  return (cycle - index % cycle) % cycle;
}

std::uint64_t start_of(const RecordingReader& recording, const Sequence& sequence,
                       std::uint64_t window) {
  return first_start(recording, sequence) +
         window * static_cast<std::uint64_t>(cycle_length(sequence));
}

/// Where a window's frames are looked for, or those of the first cycle.
Places searched(const RecordingReader& recording, const Sequence& sequence,
                std::optional<std::uint64_t> window) {
  const auto cycle = static_cast<std::uint64_t>(cycle_length(sequence));
  const auto motion = static_cast<std::uint64_t>(sequence.motion);
  if (!window) return {0, std::min(recording.count(), searched_cycles * (cycle + motion))};
  const std::uint64_t least = start_of(recording, sequence, *window);
  // A marker is seen before the cycle that it announces. Where frames are lost the next cycle
  // begins earlier; no two that are whole begin among so many frames.
  const bool marked = sequence.marker && least >= cycle;
  const std::uint64_t end = least + 2 * cycle - (sequence.marker ? 2 : 1) + motion;
  return {marked ? least - cycle : least, std::min(end, recording.count())};
}

}  // namespace

std::optional<FrameSet> first_cycle(const RecordingReader& recording, const Sequence& sequence) {
  return cycle_among(recording, sequence, searched(recording, sequence, std::nullopt));
}

std::uint32_t cycle_checksum(const RecordingReader& recording, const Sequence& sequence,
                             std::optional<std::uint64_t> window, std::uint32_t before) {
  const Places places = searched(recording, sequence, window);
  return recording.checksum(places.first, places.end, before);
}

std::uint64_t window_count(const RecordingReader& recording, const Sequence& sequence) {
  const auto cycle = static_cast<std::uint64_t>(cycle_length(sequence));
  const std::uint64_t before =
      first_start(recording, sequence) + static_cast<std::uint64_t>(sequence.motion);
  return recording.count() < before ? 0 : (recording.count() - before) / cycle;
}

std::optional<FrameSet> window_at(const RecordingReader& recording, const Sequence& sequence,
                                  std::uint64_t window) {
  return cycle_among(recording, sequence, searched(recording, sequence, window),
                     start_of(recording, sequence, window));
}

std::vector<Frame> frames_of(const FrameViews& scan, const std::string& name) {
  return scan.visit([&](const auto& views) {
    using Pixel = std::remove_const_t<std::remove_pointer_t<decltype(views[0].row(0))>>;
    std::vector<Frame> frames;
    if constexpr (std::is_same_v<Pixel, double>) {
      throw Error(fmt::format(
          "{}: unquantised frames cannot be replayed; a camera has 8 to 16 bits", name));
    } else {
      if (sizeof(Pixel) == 2 && scan.bits() <= 8) {
        throw Error(fmt::format("{}: pictures of 16 bits, but bits is {}; 9 to 16 can be replayed",
                                name, scan.bits()));
      }
      for (const auto& view : views) {
        Frame frame({scan.size(), scan.bits()});
        auto& image = std::get<Image<Pixel>>(frame.pixels);
        for (int row = 0; row < view.height(); ++row) {
          std::copy_n(view.row(row), view.width(), image.row(row));
        }
        frame.stamp.sequence = frames.size();
        frame.stamp.pattern_index = static_cast<int>(frames.size());
        frames.push_back(std::move(frame));
      }
    }
    return frames;
  });
}

}  // namespace slipstream
