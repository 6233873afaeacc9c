#include "slipstream/camera/detail/gige_packets.h"

#include <algorithm>
#include <vector>

#include "slipstream/camera/detail/big_endian.h"

namespace slipstream {
namespace {

enum class Part : std::uint32_t { leader = 1, trailer = 2, pixels = 3 };
constexpr std::uint16_t image_payload = 1;
constexpr std::uint32_t mono8 = 0x01080001;

std::vector<std::uint8_t> packet_of(Part part, std::uint16_t frame_number, std::uint32_t place) {
  std::vector<std::uint8_t> packet;
  append_big_endian(packet, std::uint16_t{0});  // success
  append_big_endian(packet, frame_number);
  append_big_endian(packet, static_cast<std::uint32_t>(part) << 24 | place);
  return packet;
}

}  // namespace

void for_each_packet(const Image<std::uint8_t>& picture, const Rectangle& region,
                     std::size_t packet_bytes, std::uint16_t frame_number,
                     std::chrono::nanoseconds taken,
                     const std::function<void(std::span<const std::uint8_t>)>& send) {
  const auto [width, height] = region.size;
  std::vector<std::uint8_t> packet = packet_of(Part::leader, frame_number, 0);
  append_big_endian(packet, std::uint16_t{0});
  append_big_endian(packet, image_payload);
  append_big_endian(packet, static_cast<std::uint64_t>(taken.count()));
  append_big_endian(packet, mono8);
  for (const int number : {width, height, region.x, region.y}) {
    append_big_endian(packet, static_cast<std::uint32_t>(number));
  }
  append_big_endian(packet, std::uint32_t{0});  // no padding
  send(packet);

  std::vector<std::uint8_t> pixels;
  for (int row = 0; row < height; ++row) {
    const std::uint8_t* first = picture.row(region.y + row) + region.x;
    pixels.insert(pixels.end(), first, first + width);
  }
  std::uint32_t place = 1;
  for (std::size_t sent = 0; sent < pixels.size(); sent += packet_bytes, ++place) {
    packet = packet_of(Part::pixels, frame_number, place);
    const std::size_t end = std::min(pixels.size(), sent + packet_bytes);
    packet.insert(packet.end(), &pixels[sent], pixels.data() + end);
    send(packet);
  }
  packet = packet_of(Part::trailer, frame_number, place);
  append_big_endian(packet, std::uint32_t{image_payload});
  append_big_endian(packet, static_cast<std::uint32_t>(height));
  send(packet);
}

}  // namespace slipstream
