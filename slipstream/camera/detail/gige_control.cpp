#include "slipstream/camera/detail/gige_control.h"

#include <algorithm>
#include <array>
#include <utility>

#include "slipstream/camera/detail/big_endian.h"

namespace slipstream {
namespace {

constexpr std::size_t register_bytes = 0x10000;
constexpr std::size_t header_bytes = 8;
constexpr std::uint8_t command_key = 0x42;
constexpr std::uint8_t wants_answer = 1;
constexpr std::uint32_t discovery_bytes = 0xf8;
constexpr std::uint32_t longest_read = 536;
constexpr int trigger_on = 1, source_is_software = 1;

enum Command : std::uint16_t {
  discover = 0x02,
  read_register = 0x80,
  write_register = 0x82,
  read_memory = 0x84,
  write_memory = 0x86,
};

struct Span {
  std::uint32_t first, end;
};
/// What a client may change: a camera's name and its description are not among it.
constexpr std::array<Span, 6> writable{{{0x100, 0x118},    // region, gain
                                        {0x120, 0x200},    // exposure, start, offset, rate
                                        {0x300, 0x400},    // triggers
                                        {0x938, 0x93c},    // heartbeat
                                        {0xa00, 0xa04},    // control
                                        {0xd00, 0xd40}}};  // stream

}  // namespace

enum class GigeControl::Status : std::uint16_t {
  success = 0,
  not_implemented = 0x8001,
  invalid_parameter = 0x8002,
  invalid_address = 0x8003,
  write_protected = 0x8004,
  access_denied = 0x8006,
};

struct GigeControl::Answer {
  Status status = Status::success;
  std::vector<std::uint8_t> payload;
};

GigeControl::GigeControl(std::vector<std::uint8_t> memory) : registers_(std::move(memory)) {
  registers_.resize(std::max(registers_.size(), register_bytes));
  description_.assign(registers_.begin() + register_bytes, registers_.end());
  registers_.resize(register_bytes);
  without_client_ = registers_;
}

std::vector<std::uint8_t> GigeControl::answer(std::span<const std::uint8_t> packet, UdpAddress from,
                                              Time now) {
  forget_silent_client(now);
  if (packet.size() < header_bytes || packet[0] != command_key) return {};
  const auto command = big_endian<std::uint16_t>(packet, 2);
  const auto payload = packet.subspan(header_bytes);
  const bool is_whole = payload.size() == big_endian<std::uint16_t>(packet, 4);
  const Answer answer =
      is_whole ? carry_out(command, payload, from) : Answer{Status::invalid_parameter, {}};
  if (client_ == from) heard_ = now;
  if (command != discover && (packet[1] & wants_answer) == 0) return {};

  std::vector<std::uint8_t> bytes;
  append_big_endian(bytes, static_cast<std::uint16_t>(answer.status));
  append_big_endian(bytes, static_cast<std::uint16_t>(command + 1));
  append_big_endian(bytes, static_cast<std::uint16_t>(answer.payload.size()));
  append_big_endian(bytes, big_endian<std::uint16_t>(packet, 6));
  bytes.insert(bytes.end(), answer.payload.begin(), answer.payload.end());
  return bytes;
}

GigeControl::Answer GigeControl::carry_out(std::uint16_t command,
                                           std::span<const std::uint8_t> payload, UdpAddress from) {
  const auto number = [&](std::size_t at) { return big_endian<std::uint32_t>(payload, at); };
  const std::size_t size = payload.size();
  const bool writes_memory = command == write_memory && size > 4;
  if (command == discover && size == 0) return read_bytes(0, discovery_bytes);
  if (command == read_register && size == 4) return read_bytes(number(0), 4);
  if (command == read_memory && size == 8) {
    Answer answer = read_bytes(number(0), number(4) & 0xffff);
    answer.payload.insert(answer.payload.begin(), payload.begin(), payload.begin() + 4);
    return answer;
  }
  if ((command == write_register && size == 8) || writes_memory) {
    Answer answer{write_bytes(number(0), payload.subspan(4), from), {}};
    append_big_endian(answer.payload, writes_memory ? number(0) : std::uint32_t{1});
    return answer;
  }
  const bool is_known = command == discover || (command >= read_register && command <= 0x87);
  return {is_known ? Status::invalid_parameter : Status::not_implemented, {}};
}

GigeControl::Answer GigeControl::read_bytes(std::uint32_t address, std::uint32_t count) const {
  if (count == 0 || count > longest_read) return {Status::invalid_parameter, {}};
  const bool beyond = address >= register_bytes;
  const std::vector<std::uint8_t>& part = beyond ? description_ : registers_;
  const std::size_t first = beyond ? address - register_bytes : address;
  if (first > part.size() || count > part.size() - first) return {Status::invalid_address, {}};
  const auto from = part.begin() + static_cast<std::ptrdiff_t>(first);
  return {Status::success, {from, from + count}};
}

GigeControl::Status GigeControl::write_bytes(std::uint32_t address,
                                             std::span<const std::uint8_t> bytes, UdpAddress from) {
  const bool asks_for_control =
      address == static_cast<std::uint32_t>(GigeRegister::control_privilege);
  const bool may = client_ ? client_ == from : asks_for_control;
  if (!may) return Status::access_denied;
  const bool fits = std::any_of(writable.begin(), writable.end(), [&](const Span& span) {
    return address >= span.first && address < span.end && bytes.size() <= span.end - address;
  });
  if (!fits) return Status::write_protected;
  std::copy(bytes.begin(), bytes.end(), registers_.begin() + address);
  if (read(GigeRegister::control_privilege) != 0) {
    client_ = from;
  } else {
    let_client_go();
  }
  return Status::success;
}

void GigeControl::forget_silent_client(Time now) {
  constexpr std::uint32_t least = 500, most = 60'000;
  const std::chrono::milliseconds longest(
      std::clamp(read(GigeRegister::heartbeat_timeout), least, most));
  if (client_ && now - heard_ > longest) let_client_go();
}

void GigeControl::let_client_go() {
  client_.reset();
  registers_ = without_client_;
}

std::optional<GigeStream> GigeControl::stream(Time now) {
  forget_silent_client(now);
  const auto at = [&](GigeRegister which) { return static_cast<std::int64_t>(read(which)); };
  using enum GigeRegister;
  const UdpAddress to{read(stream_host), static_cast<std::uint16_t>(read(stream_port))};
  const bool is_within = at(width) > 0 && at(left) + at(width) <= at(sensor_width) &&
                         at(height) > 0 && at(top) + at(height) <= at(sensor_height);
  if (!client_ || at(acquisition) == 0 || to.host != client_->host || to.port == 0 || !is_within) {
    return std::nullopt;
  }
  const auto pixels = [&](GigeRegister which) { return static_cast<int>(read(which)); };
  constexpr std::uint32_t least_packet = 576, largest_packet = 65535, headers = 36,
                          size_mask = 0xffff;
  const bool is_free = at(frame_trigger) == 0 && at(acquisition_trigger) == 0;
  const bool is_pulled = at(frame_trigger) == trigger_on &&
                         at(trigger_source) == source_is_software && at(software_trigger) == 1;
  return GigeStream{
      .to = to,
      .region = {pixels(left), pixels(top), {pixels(width), pixels(height)}},
      .packet_bytes =
          std::clamp(read(packet_size) & size_mask, least_packet, largest_packet) - headers,
      .period = std::chrono::microseconds(at(frame_period)),
      .is_free = is_free,
      .ready = is_free || is_pulled};
}

std::uint32_t GigeControl::read(GigeRegister which) const {
  return big_endian<std::uint32_t>(registers_, static_cast<std::size_t>(which));
}

void GigeControl::write(GigeRegister which, std::uint32_t value) {
  std::vector<std::uint8_t> bytes;
  append_big_endian(bytes, value);
  std::copy(bytes.begin(), bytes.end(), registers_.begin() + static_cast<std::ptrdiff_t>(which));
}

void GigeControl::set_up(GigeRegister which, std::uint32_t value) {
  write(which, value);
  std::swap(registers_, without_client_);
  write(which, value);
  std::swap(registers_, without_client_);
}

}  // namespace slipstream
