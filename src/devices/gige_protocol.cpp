#include "devices/gige_protocol.h"

#include <algorithm>
#include <bit>

#include "base/numbers.h"

namespace slipstream {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <class Number>
Number big_endian(std::span<const std::uint8_t> bytes, std::size_t at) {
  return number_at<Number, std::endian::big>(bytes, at);
}

template <class... Numbers>
void append_big_endian(Bytes& packet, const Numbers&... numbers) {
  append_numbers<std::endian::big>(packet, numbers...);
}

bool same(const sockaddr_in& a, const sockaddr_in& b) {
  return a.sin_addr.s_addr == b.sin_addr.s_addr && a.sin_port == b.sin_port;
}

using enum GigeStatus;

enum Command : std::uint16_t {
  discovery = 0x02,
  resend_packets = 0x40,
  read_register = 0x80,
  write_register = 0x82,
  read_memory = 0x84,
  write_memory = 0x86,
};

/// A longer time between two calls of listen() is a stall. Below any client's timeout.
constexpr std::chrono::milliseconds longest_pause{200};

enum class Content : std::uint32_t { leader = 1, trailer = 2, picture = 3, part = 7 };

constexpr std::uint16_t block_complete = 0, unavailable = 0x800c;

/// Packet header. Only extended IDs leave room for the number of parts.
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

/// Pixel bytes start after the header in each packet.
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

std::uint32_t payload_of(const GigeBlock& block) {
  constexpr std::uint32_t image = 1, multipart = 10;
  return block.is_multipart ? multipart : image;
}

std::uint16_t data_type(GigeComponent component) {
  constexpr std::uint16_t picture = 1, space = 5, confidence = 9;
  return component == GigeComponent::range        ? space
         : component == GigeComponent::confidence ? confidence
                                                  : picture;
}

void write_leader(const GigeBlock& block, Bytes& packet) {
  begin(packet, block, Content::leader, 0);
  append_big_endian(packet, payload_of(block), static_cast<std::uint64_t>(block.time.count()));

  if (!block.is_multipart) {
    append_big_endian(packet, block.parts.front().pixels);
    append_region(packet, block.region);
    return;
  }

  // One description for each part.
  for (const GigePart& part : block.parts) {
    append_big_endian(packet, data_type(part.component), std::uint16_t{0},
                      static_cast<std::uint32_t>(part.bytes.size()), part.pixels);
    append_big_endian(packet, std::uint64_t{0});  // one source, one zone
    append_big_endian(packet, part.component, std::uint16_t{0});
    append_region(packet, block.region);
    append_big_endian(packet, std::uint32_t{0});
  }
}

}  // namespace

Bytes GigeControl::answer(std::span<const std::uint8_t> packet, const sockaddr_in& from, Time now) {
  constexpr std::size_t header_bytes = 8;
  constexpr std::uint8_t command_key = 0x42, wants_answer = 1, has_long_numbers = 0x10;

  // 1. Check the packet; anything but a command gets no answer.
  forget_silent_client(now);
  if (packet.size() < header_bytes || packet[0] != command_key) return {};

  // 2. A resend request is only noted: its answer is the packet itself, on the stream.
  const auto command = big_endian<std::uint16_t>(packet, 2);
  const auto payload = packet.subspan(header_bytes);
  const bool is_whole = payload.size() == big_endian<std::uint16_t>(packet, 4);
  if (command == resend_packets && is_whole) {
    note_resend(payload, (packet[1] & has_long_numbers) != 0, from);
    return {};
  }

  // 3. Carry out the command. Any command from the client keeps its control alive.
  Bytes result;
  const GigeStatus status =
      is_whole ? carry_out(command, payload, from, result) : invalid_parameter;
  if (client_ && same(*client_, from)) heard_ = now;
  if (command != discovery && (packet[1] & wants_answer) == 0) return {};

  // 4. The answer has the number of its command plus 1, and the request's own number.
  Bytes bytes;
  append_big_endian(bytes, status, static_cast<std::uint16_t>(command + 1),
                    static_cast<std::uint16_t>(result.size()),
                    big_endian<std::uint16_t>(packet, 6));
  bytes.insert(bytes.end(), result.begin(), result.end());
  return bytes;
}

GigeStatus GigeControl::carry_out(std::uint16_t command, std::span<const std::uint8_t> payload,
                                  const sockaddr_in& from, Bytes& result) {
  constexpr std::size_t discovery_bytes = 0xf8, longest_read = 536;

  const auto read_bytes = [&](std::size_t address, std::size_t count) {
    if (count == 0 || count > longest_read) return invalid_parameter;
    if (address + count > memory_.size()) return invalid_address;
    const auto bytes = std::span(memory_).subspan(address, count);
    result.insert(result.end(), bytes.begin(), bytes.end());
    return success;
  };

  // Discovery has no address; all other commands begin with one.
  const std::size_t size = payload.size();
  if (command == discovery) return read_bytes(0, discovery_bytes);
  if (size < 4) return invalid_parameter;
  const std::size_t address = big_endian<std::uint32_t>(payload, 0);

  if (command == read_register && size == 4) return read_bytes(address, 4);
  if (command == write_register && size == 8) {
    append_big_endian(result, std::uint32_t{1});
    return write_bytes(address, payload.subspan(4), from);
  }

  // Answers to memory commands repeat the address.
  result.assign(payload.begin(), payload.begin() + 4);
  if (command == read_memory && size == 8) {
    return read_bytes(address, big_endian<std::uint16_t>(payload, 6));
  }
  if (command == write_memory && size > 4) return write_bytes(address, payload.subspan(4), from);
  return not_implemented;
}

GigeStatus GigeControl::write_bytes(std::size_t address, std::span<const std::uint8_t> bytes,
                                    const sockaddr_in& from) {
  const bool takes_control = address == static_cast<std::size_t>(GigeRegister::control_privilege);
  if (client_ ? !same(*client_, from) : !takes_control) return access_denied;

  const bool fits = std::any_of(writable_.begin(), writable_.end(), [&](const auto& range) {
    return address >= range.first && address + bytes.size() <= range.second;
  });
  if (!fits) return write_protected;

  // Registers with rules are written whole.
  if (accept_) {
    if (address % 4 != 0 || bytes.size() != 4) return invalid_parameter;
    const GigeStatus status =
        accept_(static_cast<GigeRegister>(address), big_endian<std::uint32_t>(bytes, 0));
    if (status != success) return status;
  }

  // Writing the control privilege takes control; writing 0 there gives it up.
  std::copy(bytes.begin(), bytes.end(), memory_.data() + address);
  client_ = from;
  if (read(GigeRegister::control_privilege) == 0) let_client_go();
  return success;
}

/// It comes from the client's stream port or its control port.
void GigeControl::note_resend(std::span<const std::uint8_t> payload, bool long_numbers,
                              const sockaddr_in& from) {
  const auto target = stream_target();
  const bool may_ask = target && (same(*target, from) || same(*client_, from));
  if (!may_ask || payload.size() != (long_numbers ? 20 : 12)) return;

  // Extended numbers have 32 bits for packets and 64 for blocks, otherwise 24 and 16.
  const std::uint32_t mask = long_numbers ? 0xffffffff : 0xffffff;
  resend_ = {.block = long_numbers ? big_endian<std::uint64_t>(payload, 12)
                                   : big_endian<std::uint16_t>(payload, 2),
             .first = big_endian<std::uint32_t>(payload, 4) & mask,
             .last = big_endian<std::uint32_t>(payload, 8) & mask,
             .long_numbers = long_numbers};
}

void GigeControl::listen(Time now) {
  if (listened_ && now - *listened_ > longest_pause) {
    heard_ = std::min<Time>(heard_ + (now - *listened_) - longest_pause, now);
  }
  listened_ = now;
}

void GigeControl::forget_silent_client(Time now) {
  constexpr std::uint32_t least = 500, most = 60'000;
  // Limits, ms: a client's timeout may neither keep the camera forever nor lose it at once.
  const std::chrono::milliseconds longest(
      std::clamp(read(GigeRegister::heartbeat_timeout), least, most));

  const Time end = listened_ ? std::min<Time>(now, *listened_ + longest_pause) : now;
  if (!client_ || end - heard_ <= longest) return;
  ++silent_clients_;
  let_client_go();
}

void GigeControl::let_client_go() {
  ++ended_controls_;
  client_.reset();
  memory_ = without_client_;
}

std::optional<sockaddr_in> GigeControl::stream_target() const {
  using enum GigeRegister;
  if (!client_ || htonl(read(stream_host)) != client_->sin_addr.s_addr) return std::nullopt;
  // Sends only to the client itself, so that no other machine can be flooded.
  sockaddr_in to = *client_;
  to.sin_port = htons(static_cast<std::uint16_t>(read(stream_port)));
  return to;
}

std::optional<GigeStream> GigeControl::stream(Time now) {
  using enum GigeRegister;
  forget_silent_client(now);

  const auto is_within = [&](GigeRegister first, GigeRegister count, GigeRegister all) {
    return read(count) > 0 && std::uint64_t{read(first)} + read(count) <= read(all);
  };

  const auto to = stream_target();
  if (!to || read(acquisition) == 0 || !is_within(left, width, sensor_width) ||
      !is_within(top, height, sensor_height)) {
    return std::nullopt;
  }

  // `headers`: IPv4 20, UDP 8 and GVSP 8 bytes.
  constexpr std::uint32_t size_mask = 0xffff, least_packet = 576, headers = 36;

  const auto pixels = [&](GigeRegister which) { return static_cast<int>(read(which)); };

  return GigeStream{.to = *to,
                    .region = {pixels(left), pixels(top), {pixels(width), pixels(height)}},
                    .packet_bytes = std::max(read(packet_size) & size_mask, least_packet) - headers,
                    .period = std::chrono::microseconds(read(frame_period)),
                    .packet_delay = std::chrono::nanoseconds(read(packet_delay)),
                    .is_free = read(trigger_mode) == 0,
                    .is_triggered = read(trigger_source) == 1 && read(software_trigger) == 1};
}

std::uint32_t GigeControl::read(GigeRegister which) const {
  return big_endian<std::uint32_t>(memory_, static_cast<std::size_t>(which));
}

void GigeControl::write(GigeRegister which, std::uint32_t value) {
  change(which, value);
  const auto bytes = std::span(memory_).subspan(static_cast<std::size_t>(which), sizeof value);
  std::copy(bytes.begin(), bytes.end(), &without_client_.at(static_cast<std::size_t>(which)));
}

void GigeControl::change(GigeRegister which, std::uint32_t value) {
  Bytes bytes;
  append_big_endian(bytes, value);
  std::copy(bytes.begin(), bytes.end(), &memory_.at(static_cast<std::size_t>(which)));
}

std::size_t packet_count(const GigeBlock& block) {
  std::size_t count = 2;
  for (const GigePart& part : block.parts) count += packet_count(block, part);
  return count;
}

void write_packet(const GigeBlock& block, std::size_t place, Bytes& packet) {
  if (place == 0) return write_leader(block, packet);

  // Find the part that contains this packet: `before` counts the packets before the part, `offset`
  // its bytes.
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
  append_big_endian(packet, payload_of(block), block.region.size.height);
}

void write_missing_packet(const GigeResend& request, Bytes& packet) {
  begin(packet, unavailable, request.long_numbers, request.block, Content::picture, request.first,
        0);
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
