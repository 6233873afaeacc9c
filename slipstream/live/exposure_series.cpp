#include "slipstream/live/exposure_series.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/live/cyclic_scans.h"

namespace slipstream {

FrameSet take_window(FrameSource& frames, const Sequence& sequence, const std::string& source) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::seconds patience{10};
  frames.start();
  CyclicScans scans(frames, sequence, 1);
  const Clock::time_point end = Clock::now() + patience;
  while (Clock::now() < end) {
    std::optional<Glimpse> seen = scans.look(std::chrono::milliseconds(200));
    if (!seen) continue;
    frames.stop();
    return std::move(seen->frames.front());
  }
  frames.stop();
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
