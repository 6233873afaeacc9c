#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "slipstream/image/image.h"
#include "slipstream/image/rectangle.h"

namespace slipstream {

/// Hands the packets of a frame of Mono8 to `send`, as GigE Vision streams it (GVSP): a leader, the
/// pixels of `region`, which is within `picture`, `packet_bytes` in each, and a trailer.
void for_each_packet(const Image<std::uint8_t>& picture, const Rectangle& region,
                     std::size_t packet_bytes, std::uint16_t frame_number,
                     std::chrono::nanoseconds taken,
                     const std::function<void(std::span<const std::uint8_t>)>& send);

}  // namespace slipstream
