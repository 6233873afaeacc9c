// Sends packets of every kind to the served camera's registers, without a network.
#include "devices/gige_protocol.h"

#include <gtest/gtest.h>

#include "tests/devices/gvcp_packets.h"

namespace slipstream::gige_protocol_test {
using namespace std::chrono_literals;

const sockaddr_in client = address_of(loopback, 5000), other = address_of(loopback, 5001);
constexpr std::uint32_t control_at = 0xa00;
constexpr std::uint16_t ok = 0, not_implemented = 0x8001, invalid_parameter = 0x8002,
                        invalid_address = 0x8003, write_protected = 0x8004, access_denied = 0x8006;

Bytes some_memory() {
  Bytes memory(0x10000 + 1000);
  for (std::size_t i = 0; i < memory.size(); ++i) memory[i] = static_cast<std::uint8_t>(i % 251);
  return memory;
}

class GigeProtocolControl : public testing::Test {
 protected:
  GigeProtocolControl() {
    const std::pair<GigeRegister, std::uint32_t> numbers[] = {
        {GigeRegister::sensor_width, 64},
        {GigeRegister::sensor_height, 48},
        {GigeRegister::width, 64},
        {GigeRegister::height, 48},
        {GigeRegister::left, 0},
        {GigeRegister::top, 0},
        {GigeRegister::acquisition, 0},
        {GigeRegister::trigger_mode, 0},
        {GigeRegister::control_privilege, 0},
        {GigeRegister::frame_period, 10000},
        {GigeRegister::heartbeat_timeout, 3000},
        {GigeRegister::stream_port, 0},
        {GigeRegister::software_trigger, 0}};
    for (const auto& [which, value] : numbers) control_.write(which, value);
  }

  Bytes ask(const Bytes& packet, const sockaddr_in& from = client) {
    return control_.answer(packet, from, now_);
  }
  std::uint16_t status(const Bytes& packet, const sockaddr_in& from = client) {
    const Bytes answer = ask(packet, from);
    return answer.size() < 8 ? 0xffff : static_cast<std::uint16_t>(answer[0] << 8 | answer[1]);
  }
  std::uint16_t write(GigeRegister which, std::uint32_t value, const sockaddr_in& from = client) {
    return status(command(write_register, {static_cast<std::uint32_t>(which), value}), from);
  }
  void start_stream() {
    EXPECT_EQ(write(GigeRegister::control_privilege, 2), ok);
    EXPECT_EQ(write(GigeRegister::stream_host, loopback), ok);
    EXPECT_EQ(write(GigeRegister::stream_port, 6000), ok);
    EXPECT_EQ(write(GigeRegister::acquisition, 1), ok);
  }

  GigeControl control_{some_memory()};
  GigeControl::Time now_;
};

TEST_F(GigeProtocolControl, AnswersWithWhatItsMemoryHolds) {
  const Bytes memory = some_memory();
  const Bytes answer = ask(command(read_memory, {0x10000 + 988, 12}, 99));
  ASSERT_EQ(answer.size(), 8U + 4 + 12);
  EXPECT_EQ(Bytes(answer.begin(), answer.begin() + 8), (Bytes{0, 0, 0, 0x85, 0, 16, 0, 99}));
  EXPECT_TRUE(std::equal(answer.begin() + 12, answer.end(), memory.end() - 12));
  EXPECT_EQ(ask(command(discover, {})).size(), 8U + 0xf8);
  EXPECT_EQ(ask(command(read_register, {0xfffc})).size(), 8U + 4);
}

TEST_F(GigeProtocolControl, RefusesWhatLiesBesideItsMemory) {
  for (const std::uint32_t address : {0xfffffffcU, 0xffffffffU, 0x80000000U, 0x103e8U}) {
    EXPECT_EQ(status(command(read_register, {address})), invalid_address) << address;
    EXPECT_EQ(status(command(read_memory, {address, 512})), invalid_address) << address;
    EXPECT_EQ(status(command(read_memory, {address, 0})), invalid_parameter) << address;
  }
  EXPECT_EQ(status(command(read_memory, {0, 0xffff})), invalid_parameter);
  start_stream();
  for (const std::uint32_t address : {0U, 0x1fdU, 0x118U, 0x200U, 0x10000U, 0xfffffffcU}) {
    EXPECT_EQ(status(command(write_register, {address, 1})), write_protected) << address;
    EXPECT_EQ(status(command(write_memory, {address, 1})), write_protected) << address;
  }
  EXPECT_EQ(status(command(write_memory, {0x100})), not_implemented) << "nothing to write";
  Bytes cut = command(read_memory, {0, 4});
  cut.pop_back();
  EXPECT_EQ(status(cut), invalid_parameter);
  for (std::size_t size = 0; size < 8; ++size) EXPECT_TRUE(ask(Bytes(size, 0x42)).empty());
}

TEST_F(GigeProtocolControl, OnlyWhoHasControlWritesAndSilenceEndsIt) {
  EXPECT_EQ(write(GigeRegister::width, 32), access_denied) << "nobody has control yet";
  start_stream();
  EXPECT_EQ(write(GigeRegister::width, 32, other), access_denied);
  EXPECT_EQ(write(GigeRegister::control_privilege, 0, other), access_denied);
  now_ += 2900ms;
  EXPECT_TRUE(control_.stream(now_));
  EXPECT_EQ(ask(command(read_register, {control_at}), other).back(), 2) << "anybody may look";
  now_ += 200ms;
  EXPECT_FALSE(control_.stream(now_)) << "others' questions are no sign of life";
  EXPECT_EQ(write(GigeRegister::control_privilege, 2, other), ok);
  EXPECT_EQ(control_.read(GigeRegister::acquisition), 0U) << "the next finds it as it was";
}

TEST_F(GigeProtocolControl, AStallOfTheCameraIsNoSilenceOfItsClient) {
  start_stream();
  control_.listen(now_);
  now_ += 10s;  // the client's packets wait, behind a request of another one
  EXPECT_TRUE(control_.stream(now_));
  control_.listen(now_);
  EXPECT_EQ(write(GigeRegister::control_privilege, 2, other), access_denied);
  EXPECT_EQ(write(GigeRegister::width, 32), ok);

  for (const auto end = now_ + 3100ms; now_ < end; now_ += 100ms) control_.listen(now_);
  EXPECT_FALSE(control_.stream(now_));
  EXPECT_EQ(write(GigeRegister::control_privilege, 2, other), ok);
}

TEST_F(GigeProtocolControl, AHeartbeatOfForEverEndsWithinMinutes) {
  start_stream();
  EXPECT_EQ(write(GigeRegister::heartbeat_timeout, 0xffffffff), ok);
  EXPECT_TRUE(control_.stream(now_ + 59s));
  EXPECT_FALSE(control_.stream(now_ + 61s));
}

TEST_F(GigeProtocolControl, StreamsOnlyToItsClientAndOnlyWhatTheSensorHas) {
  start_stream();
  EXPECT_EQ(ntohl(control_.stream(now_)->to.sin_addr.s_addr), loopback);
  EXPECT_EQ(ntohs(control_.stream(now_)->to.sin_port), 6000);
  EXPECT_EQ(write(GigeRegister::stream_host, 0x08080808), ok);
  EXPECT_FALSE(control_.stream(now_)) << "frames for a third party";
  EXPECT_EQ(write(GigeRegister::stream_host, loopback), ok);
  for (const auto which : {GigeRegister::left, GigeRegister::top, GigeRegister::width}) {
    const std::uint32_t before = control_.read(which);
    for (const std::uint32_t value : {65U, 0x7fffffffU, 0xffffffffU}) {
      EXPECT_EQ(write(which, value), ok);
      EXPECT_FALSE(control_.stream(now_)) << value;
    }
    EXPECT_EQ(write(which, before), ok);
  }
  for (const std::uint32_t bytes : {0U, 37U, 0xffffffffU, 1500U}) {
    EXPECT_EQ(write(GigeRegister::packet_size, bytes), ok);
    EXPECT_GE(control_.stream(now_)->packet_bytes, 540U);
    EXPECT_LE(control_.stream(now_)->packet_bytes, 65499U);
  }
}

TEST_F(GigeProtocolControl, NoPacketWritesBesideWhatClientsMayOrEnlargesAnAnswer) {
  std::mt19937 random(18);
  const Bytes before = ask(command(read_memory, {0, 0x100}));
  const Bytes description = ask(command(read_memory, {0x10000, 512}));
  Bytes last;
  for (int i = 0; i < 200'000; ++i) {
    const bool replays = random() % 16 == 0;
    Bytes packet = replays ? last : hostile_packet(random);
    const Bytes answer = ask(packet, random() % 2 == 0 ? client : other);
    ASSERT_LE(answer.size(), 8U + 4 + 536);
    const auto stream = control_.stream(now_);
    ASSERT_TRUE(!stream || stream->region.x + stream->region.size.width <= 64);
    now_ += std::chrono::milliseconds(random() % 64);
    last = std::move(packet);
  }
  EXPECT_EQ(ask(command(read_memory, {0, 0x100})), before);
  EXPECT_EQ(ask(command(read_memory, {0x10000, 512})), description);
}

}  // namespace slipstream::gige_protocol_test
