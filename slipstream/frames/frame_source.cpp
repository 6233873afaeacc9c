#include "slipstream/frames/frame_source.h"

#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {

std::uint64_t byte_count(const FrameFormat& format) {
  const auto [width, height] = format.size;
  return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) *
         (format.bits > 8 ? 2 : 1);
}

void require_valid(const FrameFormat& format) {
  const auto [width, height] = format.size;
  if (width < 1 || height < 1) {
    throw Error(fmt::format("frames of {}x{} pixels: both must be at least 1", width, height));
  }
  if (format.bits < 8 || format.bits > 16) {
    throw Error(fmt::format("frames of {} bits: 8 to 16 can be read", format.bits));
  }
}

Frame::Frame(const FrameFormat& format) : bits(format.bits) {
  require_valid(format);
  if (bits == 8) {
    pixels = Image<std::uint8_t>(format.size);
  } else {
    pixels = Image<std::uint16_t>(format.size);
  }
}

FrameFormat Frame::format() const {
  return {std::visit([](const auto& image) { return image.size(); }, pixels), bits};
}

Reel reel_of(std::vector<Frame> frames) {
  std::vector<std::size_t> order(frames.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  return {.frames = std::move(frames), .order = std::move(order)};
}

}  // namespace slipstream
