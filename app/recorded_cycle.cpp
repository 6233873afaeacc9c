#include "app/recorded_cycle.h"

#include <algorithm>
#include <utility>
#include <variant>
#include <vector>

#include "slipstream/io/recording.h"
#include "slipstream/live/pattern_windows.h"

namespace slipstream::app {
namespace {

/// Cycles that are searched for a whole one, and as many as PatternWindows may keep of them.
constexpr std::uint64_t searched_cycles = 8, kept_cycles = 4;

FrameSet frames_of(const std::vector<Pooled<Frame>>& window) {
  const int bits = window.front()->bits;
  return std::visit(
      [&]<class Pixel>(const Image<Pixel>&) {
        std::vector<Image<Pixel>> images;
        images.reserve(window.size());
        for (const Pooled<Frame>& frame : window) {
          images.push_back(std::get<Image<Pixel>>(frame->pixels));
        }
        if constexpr (sizeof(Pixel) == 1) {
          return FrameSet(std::move(images));
        } else {
          return FrameSet(std::move(images), bits);
        }
      },
      window.front()->pixels);
}

/// The first whole window, in pattern order; none where none of the first cycles is.
std::optional<FrameSet> first_window(const RecordingReader& reader, const Sequence& sequence) {
  const auto cycle = static_cast<std::uint64_t>(cycle_length(sequence));
  const FrameFormat& format = reader.header().format;
  PatternWindows windows(
      sequence, sequence.marker ? PatternIndexing::marker : PatternIndexing::told, format.size);
  const std::uint64_t searched = std::min(reader.count(), searched_cycles * cycle);
  Pool<Frame> pool(std::min(searched, kept_cycles * cycle + 1), [&] { return Frame(format); });
  std::vector<Pooled<Frame>> window;
  for (std::uint64_t n = 0; n < searched; ++n) {
    Pooled<Frame> frame = pool.take();
    if (!frame) break;
    if (!reader.read(n, frame.fill())) continue;
    windows.put(frame);
    frame = {};
    if (windows.next(window)) return frames_of(window);
  }
  return std::nullopt;
}

}  // namespace

std::optional<Scan> first_cycle(const std::filesystem::path& recording) {
  const RecordingReader reader(recording);
  const RecordingHeader& header = reader.header();
  if (!header.sequence) return std::nullopt;
  std::optional<FrameSet> frames = first_window(reader, *header.sequence);
  if (!frames) return std::nullopt;
  Scan scan{.frames = std::move(*frames), .sequence = *header.sequence};
  scan.sequence.marker = false;  // no frame of the window is one
  if (header.scanner) {
    scan.scanner =
        completed(*header.scanner, recording.string(), scan.frames.size(), scan.sequence.projector);
    scan.sequence.projector = scan.scanner->projector.size;
  }
  return merged(std::move(scan));
}

}  // namespace slipstream::app
