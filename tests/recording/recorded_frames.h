#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "slipstream/frame_source.h"

namespace slipstream {

inline constexpr FrameFormat some_format{{21, 13}, 8};

/// Frame `number`, with its own pixels; frames are 1 ms apart.
inline Frame some_frame(int number, const FrameFormat& format = some_format) {
  Frame frame(format);
  std::mt19937 random(static_cast<unsigned>(number));
  std::visit(
      [&](auto& image) {
        for (auto& pixel : image) {
          pixel = static_cast<std::remove_reference_t<decltype(pixel)>>(random() &
                                                                        ((1U << format.bits) - 1));
        }
      },
      frame.pixels);
  frame.stamp = {
      .sequence = static_cast<std::uint64_t>(number),
      .pattern_index = number % 4,
      .device_time = std::chrono::milliseconds(1000 + number),
      .host_time = std::chrono::steady_clock::time_point(std::chrono::milliseconds(number))};
  return frame;
}

inline bool same_pixels(const Frame& a, const Frame& b) {
  if (a.format() != b.format()) return false;
  return std::visit(
      [&](const auto& image) {
        const auto& other = std::get<std::remove_cvref_t<decltype(image)>>(b.pixels);
        return std::equal(image.begin(), image.end(), other.begin());
      },
      a.pixels);
}

}  // namespace slipstream
