#include "slipstream/live/window_frames.h"

#include <cstdint>
#include <variant>

namespace slipstream {
namespace {

template <class Pixel>
std::vector<Image<Pixel>> copies(const std::vector<Pooled<Frame>>& window) {
  std::vector<Image<Pixel>> images;
  for (const Pooled<Frame>& frame : window) {
    images.push_back(std::get<Image<Pixel>>(frame->pixels));
  }
  return images;
}

}  // namespace

FrameSet frame_set_of(const std::vector<Pooled<Frame>>& window) {
  if (window.empty()) return {};
  const Frame& first = *window.front();
  if (std::holds_alternative<Image<std::uint8_t>>(first.pixels)) {
    return FrameSet(copies<std::uint8_t>(window));
  }
  return {copies<std::uint16_t>(window), first.bits};
}

}  // namespace slipstream
