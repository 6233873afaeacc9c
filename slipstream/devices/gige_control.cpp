#include "slipstream/devices/gige_control.h"

#include <algorithm>
#include <utility>

#include "slipstream/base/numbers.h"

namespace slipstream {
namespace {

using Bytes = std::vector<std::uint8_t>;

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

}  // namespace

GigeControl::Writable GigeControl::fake_camera() {
  return {{0x100, 0x118}, {0x120, 0x200}, {0x300, 0x400},
          {0x938, 0x93c}, {0xa00, 0xa04}, {0xd00, 0xd40}};
}

GigeControl::GigeControl(Bytes memory, Writable writable, Accept accept)
    : memory_(std::move(memory)),
      without_client_(memory_),
      writable_(std::move(writable)),
      accept_(std::move(accept)) {}

Bytes GigeControl::answer(std::span<const std::uint8_t> packet, const sockaddr_in& from, Time now) {
  constexpr std::size_t header_bytes = 8;
  constexpr std::uint8_t command_key = 0x42, wants_answer = 1, has_long_numbers = 0x10;
  forget_silent_client(now);
  if (packet.size() < header_bytes || packet[0] != command_key) return {};
  const auto command = number_at<std::uint16_t, std::endian::big>(packet, 2);
  const auto payload = packet.subspan(header_bytes);
  const bool is_whole = payload.size() == number_at<std::uint16_t, std::endian::big>(packet, 4);
  if (command == resend_packets && is_whole) {
    note_resend(payload, (packet[1] & has_long_numbers) != 0, from);
    return {};
  }
  Bytes result;
  const GigeStatus status =
      is_whole ? carry_out(command, payload, from, result) : invalid_parameter;
  if (client_ && same(*client_, from)) heard_ = now;
  if (command != discovery && (packet[1] & wants_answer) == 0) return {};

  Bytes bytes;
  append_numbers<std::endian::big>(bytes, static_cast<std::uint16_t>(status),
                                   static_cast<std::uint16_t>(command + 1),
                                   static_cast<std::uint16_t>(result.size()),
                                   number_at<std::uint16_t, std::endian::big>(packet, 6));
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
  const std::size_t size = payload.size();
  if (command == discovery) return read_bytes(0, discovery_bytes);
  if (size < 4) return invalid_parameter;
  const std::size_t address = number_at<std::uint32_t, std::endian::big>(payload, 0);
  if (command == read_register && size == 4) return read_bytes(address, 4);
  if (command == write_register && size == 8) {
    append_numbers<std::endian::big>(result, std::uint32_t{1});
    return write_bytes(address, payload.subspan(4), from);
  }
  result.assign(payload.begin(), payload.begin() + 4);
  if (command == read_memory && size == 8) {
    return read_bytes(address, number_at<std::uint16_t, std::endian::big>(payload, 6));
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
  if (accept_) {
    if (address % 4 != 0 || bytes.size() != 4) return invalid_parameter;
    const GigeStatus status = accept_(static_cast<GigeRegister>(address),
                                      number_at<std::uint32_t, std::endian::big>(bytes, 0));
    if (status != success) return status;
  }
  std::copy(bytes.begin(), bytes.end(), &memory_[address]);
  client_ = from;
  if (read(GigeRegister::control_privilege) == 0) let_client_go();
  return success;
}

/// It comes from where the client takes its frames, or from where it asks.
void GigeControl::note_resend(std::span<const std::uint8_t> payload, bool long_numbers,
                              const sockaddr_in& from) {
  const auto target = stream_target();
  const bool may_ask = target && (same(*target, from) || same(*client_, from));
  if (!may_ask || payload.size() != (long_numbers ? 20 : 12)) return;
  const std::uint32_t mask = long_numbers ? 0xffffffff : 0xffffff;
  resend_ = {.block = long_numbers ? number_at<std::uint64_t, std::endian::big>(payload, 12)
                                   : number_at<std::uint16_t, std::endian::big>(payload, 2),
             .first = number_at<std::uint32_t, std::endian::big>(payload, 4) & mask,
             .last = number_at<std::uint32_t, std::endian::big>(payload, 8) & mask,
             .long_numbers = long_numbers};
}

void GigeControl::forget_silent_client(Time now) {
  constexpr std::uint32_t least = 500, most = 60'000;
  const std::chrono::milliseconds longest(
      std::clamp(read(GigeRegister::heartbeat_timeout), least, most));
  if (!client_ || now - heard_ <= longest) return;
  ++silent_clients_;
  let_client_go();
}

void GigeControl::let_client_go() {
  client_.reset();
  memory_ = without_client_;
}

std::optional<sockaddr_in> GigeControl::stream_target() const {
  using enum GigeRegister;
  if (!client_ || htonl(read(stream_host)) != client_->sin_addr.s_addr) return std::nullopt;
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
  return number_at<std::uint32_t, std::endian::big>(memory_, static_cast<std::size_t>(which));
}

void GigeControl::write(GigeRegister which, std::uint32_t value) {
  change(which, value);
  Bytes bytes;
  append_numbers<std::endian::big>(bytes, value);
  std::copy(bytes.begin(), bytes.end(), &without_client_.at(static_cast<std::size_t>(which)));
}

void GigeControl::change(GigeRegister which, std::uint32_t value) {
  Bytes bytes;
  append_numbers<std::endian::big>(bytes, value);
  std::copy(bytes.begin(), bytes.end(), &memory_.at(static_cast<std::size_t>(which)));
}

}  // namespace slipstream
