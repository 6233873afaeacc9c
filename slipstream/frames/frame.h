#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <variant>

#include "slipstream/base/image.h"

namespace slipstream {

/// Size and depth of a camera's pictures: 8 bits, or 9 to 16 in 16-bit pixels.
struct FrameFormat {
  Size size;
  int bits = 8;

  friend bool operator==(const FrameFormat&, const FrameFormat&) = default;
};

/// Of its pixels.
std::uint64_t byte_count(const FrameFormat& format);

/// Throws Error unless the size is positive and the bits are 8 to 16.
void require_valid(const FrameFormat& format);

/// Where and when a frame was taken.
struct FrameStamp {
  /// The device's count of frames, from 0 at the start; a gap is a lost frame.
  std::uint64_t sequence = 0;
  /// Which pattern it shows, where the source itself knows; none where it must be counted.
  std::optional<int> pattern_index;
  std::chrono::nanoseconds device_time{};           ///< of the device's own clock
  std::chrono::steady_clock::time_point host_time;  ///< when the frame was whole in this machine
};

/// One camera picture. Its memory is allocated once and filled again and again.
struct Frame {
  Frame() = default;
  /// Black. Throws Error where the format is not valid.
  explicit Frame(const FrameFormat& format);

  [[nodiscard]] FrameFormat format() const;

  std::variant<Image<std::uint8_t>, Image<std::uint16_t>> pixels;
  int bits = 8;
  FrameStamp stamp;
};

}  // namespace slipstream
