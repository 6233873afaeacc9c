#include "slipstream/camera/detail/gige_protocol.h"

#include <algorithm>
#include <array>
#include <concepts>
#include <utility>

namespace slipstream {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Networks send the highest byte first.
template <std::unsigned_integral Number>
Number number_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  Number number = 0;
  for (const auto byte : bytes.subspan(at, sizeof(Number))) {
    number = static_cast<Number>(number << 8 | byte);
  }
  return number;
}

template <std::unsigned_integral Number>
void append(Bytes& bytes, Number number) {
  for (int shift = 8 * (sizeof(Number) - 1); shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(number >> shift));
  }
}

bool same(const sockaddr_in& a, const sockaddr_in& b) {
  return a.sin_addr.s_addr == b.sin_addr.s_addr && a.sin_port == b.sin_port;
}

enum Status : std::uint16_t {
  success = 0,
  not_implemented = 0x8001,
  invalid_parameter = 0x8002,
  invalid_address = 0x8003,
  write_protected = 0x8004,
  access_denied = 0x8006,
};

enum Command : std::uint16_t {
  discovery = 0x02,
  read_register = 0x80,
  write_register = 0x82,
  read_memory = 0x84,
  write_memory = 0x86,
};

/// From and up to where a client may write: nothing of a camera's name, sensor and description.
constexpr std::array<std::pair<std::size_t, std::size_t>, 6> writable{{{0x100, 0x118},
                                                                       {0x120, 0x200},
                                                                       {0x300, 0x400},
                                                                       {0x938, 0x93c},
                                                                       {0xa00, 0xa04},
                                                                       {0xd00, 0xd40}}};

/// How packet `place` of a frame begins.
enum class Part : std::uint32_t { leader = 1, trailer = 2, pixels = 3 };
Bytes begun(Part part, std::uint16_t frame_number, std::uint32_t place) {
  Bytes packet;
  append(packet, std::uint16_t{success});
  append(packet, frame_number);
  append(packet, static_cast<std::uint32_t>(part) << 24 | place);
  return packet;
}

}  // namespace

GigeControl::GigeControl(Bytes memory) : memory_(std::move(memory)), without_client_(memory_) {}

Bytes GigeControl::answer(std::span<const std::uint8_t> packet, const sockaddr_in& from, Time now) {
  constexpr std::size_t header_bytes = 8;
  constexpr std::uint8_t command_key = 0x42, wants_answer = 1;
  forget_silent_client(now);
  if (packet.size() < header_bytes || packet[0] != command_key) return {};
  const auto command = number_at<std::uint16_t>(packet, 2);
  const auto payload = packet.subspan(header_bytes);
  const bool is_whole = payload.size() == number_at<std::uint16_t>(packet, 4);
  Bytes result;
  const std::uint16_t status =
      is_whole ? carry_out(command, payload, from, result) : std::uint16_t{invalid_parameter};
  if (client_ && same(*client_, from)) heard_ = now;
  if (command != discovery && (packet[1] & wants_answer) == 0) return {};

  Bytes bytes;
  append(bytes, status);
  append(bytes, static_cast<std::uint16_t>(command + 1));
  append(bytes, static_cast<std::uint16_t>(result.size()));
  append(bytes, number_at<std::uint16_t>(packet, 6));
  bytes.insert(bytes.end(), result.begin(), result.end());
  return bytes;
}

std::uint16_t GigeControl::carry_out(std::uint16_t command, std::span<const std::uint8_t> payload,
                                     const sockaddr_in& from, Bytes& result) {
  constexpr std::size_t discovery_bytes = 0xf8, longest_read = 536;
  const auto read_bytes = [&](std::size_t address, std::size_t count) -> std::uint16_t {
    if (count == 0 || count > longest_read) return invalid_parameter;
    if (address + count > memory_.size()) return invalid_address;
    const auto bytes = std::span(memory_).subspan(address, count);
    result.insert(result.end(), bytes.begin(), bytes.end());
    return success;
  };
  const std::size_t size = payload.size();
  if (command == discovery) return read_bytes(0, discovery_bytes);
  if (size < 4) return invalid_parameter;
  const std::size_t address = number_at<std::uint32_t>(payload, 0);
  if (command == read_register && size == 4) return read_bytes(address, 4);
  if (command == write_register && size == 8) {
    append(result, std::uint32_t{1});
    return write_bytes(address, payload.subspan(4), from);
  }
  result.assign(payload.begin(), payload.begin() + 4);
  if (command == read_memory && size == 8) {
    return read_bytes(address, number_at<std::uint16_t>(payload, 6));
  }
  if (command == write_memory && size > 4) return write_bytes(address, payload.subspan(4), from);
  return not_implemented;
}

std::uint16_t GigeControl::write_bytes(std::size_t address, std::span<const std::uint8_t> bytes,
                                       const sockaddr_in& from) {
  const bool takes_control = address == static_cast<std::size_t>(GigeRegister::control_privilege);
  if (client_ ? !same(*client_, from) : !takes_control) return access_denied;
  const bool fits = std::any_of(writable.begin(), writable.end(), [&](const auto& range) {
    return address >= range.first && address + bytes.size() <= range.second;
  });
  if (!fits) return write_protected;
  std::copy(bytes.begin(), bytes.end(), &memory_[address]);
  client_ = from;
  if (read(GigeRegister::control_privilege) == 0) let_client_go();
  return success;
}

void GigeControl::forget_silent_client(Time now) {
  constexpr std::uint32_t least = 500, most = 60'000;
  const std::chrono::milliseconds longest(
      std::clamp(read(GigeRegister::heartbeat_timeout), least, most));
  if (client_ && now - heard_ > longest) let_client_go();
}

void GigeControl::let_client_go() {
  client_.reset();
  memory_ = without_client_;
}

std::optional<GigeStream> GigeControl::stream(Time now) {
  using enum GigeRegister;
  forget_silent_client(now);
  const auto is_within = [&](GigeRegister first, GigeRegister count, GigeRegister all) {
    return read(count) > 0 && std::uint64_t{read(first)} + read(count) <= read(all);
  };
  if (!client_ || read(acquisition) == 0 || htonl(read(stream_host)) != client_->sin_addr.s_addr ||
      !is_within(left, width, sensor_width) || !is_within(top, height, sensor_height)) {
    return std::nullopt;
  }
  constexpr std::uint32_t size_mask = 0xffff, least_packet = 576, headers = 36;
  const auto pixels = [&](GigeRegister which) { return static_cast<int>(read(which)); };
  GigeStream wanted{.to = *client_,
                    .region = {pixels(left), pixels(top), {pixels(width), pixels(height)}},
                    .packet_bytes = std::max(read(packet_size) & size_mask, least_packet) - headers,
                    .period = std::chrono::microseconds(read(frame_period)),
                    .is_free = read(trigger_mode) == 0,
                    .is_triggered = read(trigger_source) == 1 && read(software_trigger) == 1};
  wanted.to.sin_port = htons(static_cast<std::uint16_t>(read(stream_port)));
  return wanted;
}

std::uint32_t GigeControl::read(GigeRegister which) const {
  return number_at<std::uint32_t>(memory_, static_cast<std::size_t>(which));
}

void GigeControl::write(GigeRegister which, std::uint32_t value) {
  Bytes bytes;
  append(bytes, value);
  for (Bytes* memory : {&memory_, &without_client_}) {
    std::copy(bytes.begin(), bytes.end(), &memory->at(static_cast<std::size_t>(which)));
  }
}

void for_each_packet(const Image<std::uint8_t>& picture, const GigeStream& stream,
                     std::uint16_t frame_number,
                     const std::function<void(std::span<const std::uint8_t>)>& send) {
  constexpr std::uint32_t image_payload = 1, mono8 = 0x01080001, no_padding = 0;
  const auto& [left, top, size] = stream.region;
  const auto taken = std::chrono::steady_clock::now().time_since_epoch();
  Bytes packet = begun(Part::leader, frame_number, 0);
  append(packet, image_payload);
  append(packet, static_cast<std::uint64_t>(std::chrono::nanoseconds(taken).count()));
  append(packet, mono8);
  for (const int number : {size.width, size.height, left, top}) {
    append(packet, static_cast<std::uint32_t>(number));
  }
  append(packet, no_padding);
  send(packet);

  Bytes pixels;
  for (int row = top; row < top + size.height; ++row) {
    pixels.insert(pixels.end(), picture.row(row) + left, picture.row(row) + left + size.width);
  }
  std::uint32_t place = 1;
  for (auto rest = std::span<const std::uint8_t>(pixels); !rest.empty(); ++place) {
    const auto part = rest.first(std::min(rest.size(), stream.packet_bytes));
    packet = begun(Part::pixels, frame_number, place);
    packet.insert(packet.end(), part.begin(), part.end());
    send(packet);
    rest = rest.subspan(part.size());
  }
  packet = begun(Part::trailer, frame_number, place);
  append(packet, image_payload);
  append(packet, static_cast<std::uint32_t>(size.height));
  send(packet);
}

}  // namespace slipstream
