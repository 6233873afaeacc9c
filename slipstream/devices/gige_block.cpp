#include "slipstream/devices/gige_block.h"

#include <algorithm>

#include "slipstream/base/numbers.h"

namespace slipstream {
namespace {

using Bytes = std::vector<std::uint8_t>;

enum class Content : std::uint32_t { leader = 1, trailer = 2, picture = 3, part = 7 };

constexpr std::uint16_t block_complete = 0, unavailable = 0x800c;
constexpr std::uint32_t image_payload = 1, multipart_payload = 10;

template <class... Numbers>
void append_big_endian(Bytes& packet, const Numbers&... numbers) {
  append_numbers<std::endian::big>(packet, numbers...);
}

/// How a packet begins. Only long numbers leave room for the number of a block's parts.
void begin(Bytes& packet, std::uint16_t status, bool long_numbers, std::uint64_t block,
           Content content, std::size_t place, std::size_t parts) {
  packet.clear();
  append_big_endian(packet, status);
  const std::uint32_t kind = static_cast<std::uint32_t>(content) << 24;
  if (!long_numbers) {
    append_big_endian(packet, static_cast<std::uint16_t>(block),
                      kind | static_cast<std::uint32_t>(place));
    return;
  }
  append_big_endian(packet, std::uint16_t{0}, 0x80000000 | kind | static_cast<std::uint32_t>(parts),
                    block, static_cast<std::uint32_t>(place));
}

void begin(Bytes& packet, const GigeBlock& block, Content content, std::size_t place) {
  const std::size_t parts = content == Content::leader ? block.parts.size() : 0;
  begin(packet, block_complete, block.is_multipart, block.number, content, place, parts);
}

/// In each packet, after what precedes them.
std::size_t picture_bytes(const GigeBlock& block) {
  constexpr std::size_t longer_head = 20;
  return block.packet_bytes - (block.is_multipart ? longer_head : 0);
}

std::size_t packet_count(const GigeBlock& block, const GigePart& part) {
  return (part.bytes.size() + picture_bytes(block) - 1) / picture_bytes(block);
}

void append_region(Bytes& packet, const Rectangle& region) {
  const auto& [left, top, size] = region;
  append_big_endian(packet, size.width, size.height, left, top, 0);  // no padding
}

std::uint16_t data_type(GigeComponent component) {
  constexpr std::uint16_t picture = 1, space = 5, confidence = 9;
  return component == GigeComponent::range        ? space
         : component == GigeComponent::confidence ? confidence
                                                  : picture;
}

void write_leader(const GigeBlock& block, Bytes& packet) {
  begin(packet, block, Content::leader, 0);
  append_big_endian(packet, block.is_multipart ? multipart_payload : image_payload,
                    static_cast<std::uint64_t>(block.time.count()));
  if (!block.is_multipart) {
    append_big_endian(packet, static_cast<std::uint32_t>(block.parts.front().pixels));
    append_region(packet, block.region);
    return;
  }
  for (const GigePart& part : block.parts) {
    append_big_endian(packet, data_type(part.component), std::uint16_t{0},
                      static_cast<std::uint32_t>(part.bytes.size()),
                      static_cast<std::uint32_t>(part.pixels));
    append_big_endian(packet, std::uint64_t{0});  // one source, one zone
    append_big_endian(packet, static_cast<std::uint16_t>(part.component), std::uint16_t{0});
    append_region(packet, block.region);
    append_big_endian(packet, std::uint32_t{0});
  }
}

}  // namespace

std::size_t packet_count(const GigeBlock& block) {
  std::size_t count = 2;
  for (const GigePart& part : block.parts) count += packet_count(block, part);
  return count;
}

void write_packet(const GigeBlock& block, std::size_t place, Bytes& packet) {
  if (place == 0) return write_leader(block, packet);
  std::size_t before = 1, offset = 0;
  for (std::size_t number = 0; number < block.parts.size(); ++number) {
    const GigePart& part = block.parts[number];
    const std::size_t count = packet_count(block, part);
    if (place < before + count) {
      const std::size_t at = (place - before) * picture_bytes(block);
      begin(packet, block, block.is_multipart ? Content::part : Content::picture, place);
      if (block.is_multipart)
        append_big_endian(packet, std::uint64_t{number} << 56 | (offset + at));
      const auto first = part.bytes.begin() + static_cast<std::ptrdiff_t>(at);
      const std::size_t bytes = std::min(picture_bytes(block), part.bytes.size() - at);
      packet.insert(packet.end(), first, first + static_cast<std::ptrdiff_t>(bytes));
      return;
    }
    before += count;
    offset += part.bytes.size();
  }
  begin(packet, block, Content::trailer, place);
  append_big_endian(packet, block.is_multipart ? multipart_payload : image_payload,
                    static_cast<std::uint32_t>(block.region.size.height));
}

void write_missing_packet(const GigeResend& asked, Bytes& packet) {
  begin(packet, unavailable, asked.long_numbers, asked.block, Content::picture, asked.first, 0);
}

GigeBlock block_of(const Image<std::uint8_t>& picture, const GigeStream& stream,
                   std::uint16_t number) {
  const auto& [left, top, size] = stream.region;
  GigeBlock block{.number = number,
                  .time = std::chrono::steady_clock::now().time_since_epoch(),
                  .region = stream.region,
                  .packet_bytes = stream.packet_bytes,
                  .parts = {{}}};
  Bytes& pixels = block.parts.front().bytes;
  for (int row = top; row < top + size.height; ++row) {
    pixels.insert(pixels.end(), picture.row(row) + left, picture.row(row) + left + size.width);
  }
  return block;
}

void for_each_packet(const GigeBlock& block,
                     const std::function<void(std::span<const std::uint8_t>)>& send) {
  Bytes packet;
  for (std::size_t place = 0; place < packet_count(block); ++place) {
    write_packet(block, place, packet);
    send(packet);
  }
}

}  // namespace slipstream
