#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/base/size.h"
#include "slipstream/devices/gige_control.h"

namespace slipstream {

/// What a picture shows, as GenICam numbers it.
enum class GigeComponent : std::uint16_t { intensity = 1, range = 4, confidence = 6 };

/// Its pixels as GenICam numbers them (PFNC).
enum class GigePixels : std::uint32_t {
  mono8 = 0x01080001,
  confidence8 = 0x010800c6,
  coord3d_c16 = 0x011000b8,
  coord3d_c32f = 0x012000bf,
  coord3d_abc32f = 0x026000c0,
};

constexpr std::size_t bytes_per_pixel(GigePixels pixels) {
  return (static_cast<std::uint32_t>(pixels) >> 16 & 0xff) / 8;
}

/// One picture of a block, little-endian, row by row.
struct GigePart {
  GigeComponent component = GigeComponent::intensity;
  GigePixels pixels = GigePixels::mono8;
  std::vector<std::uint8_t> bytes{};
};

/// What GigE Vision streams at a time (GVSP): one picture, or several of one region.
struct GigeBlock {
  std::uint64_t number = 1;  ///< from 1; of one picture alone at most 65535
  std::chrono::nanoseconds time{};
  Rectangle region{};
  bool is_multipart = false;
  std::size_t packet_bytes = 0;  ///< of GigeStream
  std::vector<GigePart> parts{};
};

/// Of a leader, the pictures' bytes and a trailer.
std::size_t packet_count(const GigeBlock& block);
/// Into `packet`, whose memory is used; `place` is below packet_count().
void write_packet(const GigeBlock& block, std::size_t place, std::vector<std::uint8_t>& packet);
/// Likewise the answer where a block's packet is asked for that there is no more.
void write_missing_packet(const GigeResend& asked, std::vector<std::uint8_t>& packet);

/// The region of a picture, which it is within, taken now.
GigeBlock block_of(const Image<std::uint8_t>& picture, const GigeStream& stream,
                   std::uint16_t number);
void for_each_packet(const GigeBlock& block,
                     const std::function<void(std::span<const std::uint8_t>)>& send);

}  // namespace slipstream
