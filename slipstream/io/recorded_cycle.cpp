#include "slipstream/io/recorded_cycle.h"

#include <algorithm>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "slipstream/capture/scan_camera.h"
#include "slipstream/cycle/pattern_windows.h"
#include "slipstream/error/error.h"

namespace slipstream {
namespace {

/// Cycles that are searched for a whole one, and as many as PatternWindows may keep of them.
constexpr std::uint64_t searched_cycles = 8, kept_cycles = 4;

}  // namespace

std::optional<FrameSet> first_cycle(const RecordingReader& recording, const Sequence& sequence) {
  const auto cycle = static_cast<std::uint64_t>(cycle_length(sequence) + sequence.motion);
  PatternWindows windows(sequence,
                         sequence.marker ? PatternIndexing::marker : PatternIndexing::told,
                         recording.header().format.size);
  const std::uint64_t searched = std::min(recording.count(), searched_cycles * cycle);
  // Frames take their memory when they are read.
  Pool<Frame> pool(std::min(searched, kept_cycles * cycle + 1), [] { return Frame(); });
  std::vector<Pooled<Frame>> window;
  for (std::uint64_t n = 0; n < searched; ++n) {
    Pooled<Frame> frame = pool.take();
    if (!frame) break;
    if (!recording.read(n, frame.fill())) continue;
    windows.put(frame);
    frame = {};
    if (!windows.next(window) || windows.first_pattern() != 0) continue;
    return frame_set_of(static_cast<int>(window.size()), [&](int place) -> const Frame& {
      return *window[static_cast<std::size_t>(place)];
    });
  }
  return std::nullopt;
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
