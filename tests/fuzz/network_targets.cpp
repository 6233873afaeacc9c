// Packets to the served camera, and the answers of a driver.
#include "slipstream/gige/gige_block.h"
#include "tests/camera/gvcp_packets.h"
#include "tests/fuzz/target.h"

namespace slipstream {
namespace {

constexpr auto at = [](GigeRegister which) { return static_cast<std::uint32_t>(which); };

/// Packets one behind another, each after its length in a byte and who sends it in another.
Bytes conversation(const std::vector<Bytes>& packets) {
  Bytes bytes;
  for (const Bytes& packet : packets) {
    bytes.push_back(static_cast<std::uint8_t>(packet.size()));
    bytes.push_back(0);
    bytes.insert(bytes.end(), packet.begin(), packet.end());
  }
  return bytes;
}

std::vector<Bytes> conversations() {
  return {conversation({command(discover, {}), command(read_memory, {0x200, 512}),
                        command(read_register, {0xfffffffc})}),
          conversation({command(write_register, {at(GigeRegister::control_privilege), 2}),
                        command(write_register, {at(GigeRegister::stream_host), loopback}),
                        command(write_register, {at(GigeRegister::acquisition), 1}),
                        command(write_memory, {at(GigeRegister::left), 3, 4}),
                        command(write_register, {at(GigeRegister::control_privilege), 0})})};
}

/// Each input is a conversation; frames that the camera would send are made.
void answer_packets(std::span<const std::uint8_t> input) {
  static const GigeControl untouched = [] {
    GigeControl control(Bytes(0x10000 + 64));
    for (const auto which : {GigeRegister::sensor_width, GigeRegister::width})
      control.write(which, 64);
    for (const auto which : {GigeRegister::sensor_height, GigeRegister::height})
      control.write(which, 48);
    return control;
  }();
  static const Image<std::uint8_t> picture({64, 48});
  GigeControl control = untouched;
  GigeControl::Time now;
  while (input.size() >= 2) {
    const auto packet = input.subspan(2, std::min<std::size_t>(input[0], input.size() - 2));
    now += std::chrono::milliseconds(100 * (input[1] >> 2));
    const auto answer =
        control.answer(packet, address_of(loopback, static_cast<std::uint16_t>(input[1] & 3)), now);
    if (answer.size() > 8 + 4 + 536) throw std::logic_error("an answer too long");
    if (const auto stream = control.stream(now)) {
      std::size_t bytes = 0;
      for_each_packet(block_of(picture, *stream, 1), [&](auto part) { bytes += part.size(); });
      if (bytes < 8U + 36 + 8 + 16) throw std::logic_error("a frame too short");
    }
    input = input.subspan(2 + packet.size());
  }
}

const bool known = add_fuzz_target({"gvcp", conversations, answer_packets});

}  // namespace
}  // namespace slipstream
