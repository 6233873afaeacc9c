// Hostile packets: to the served camera while a client streams, and to the client while the camera
// streams.
#include <atomic>
#include <cstdlib>
#include <thread>

#include <gtest/gtest.h>

#include "devices/genicam.h"
#include "devices/gige_protocol.h"
#include "tests/devices/gvcp_packets.h"
#include "tests/devices/served_camera.h"
#include "tests/recording/recorded_frames.h"

namespace slipstream::hostile_network_test {
using namespace std::chrono_literals;
using std::chrono::steady_clock;

/// Returns the camera's answer to `packet`, skipping others; empty after ten seconds without one.
Bytes ask(const ClientSocket& socket, const Bytes& packet) {
  socket.send(packet, camera_port);
  for (const auto end = steady_clock::now() + 10s; steady_clock::now() < end;) {
    const Bytes answer = socket.receive(1ms);
    if (answer.size() < 8) continue;
    if (std::equal(packet.begin() + 6, packet.begin() + 8, answer.begin() + 6)) return answer;
  }
  return {};
}

/// SLIPSTREAM_HOSTILE_PACKETS; default 10^4.
int packets_wanted() {
  const char* asked = std::getenv("SLIPSTREAM_HOSTILE_PACKETS");
  return asked == nullptr ? 10'000 : std::atoi(asked);
}

class HostileNetwork : public testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 4; ++i) rendered_.push_back(some_frame(i, {{320, 240}, 8}));
    camera_ = serve(rendered_, "HOSTILE");
    REQUIRE_CAMERA(camera_);
  }
  [[nodiscard]] static std::unique_ptr<FrameSource> open() {
    return open_genicam_camera(served_address,
                               {.frame_rate = 100, .packet_size = 8000, .cycle = 4});
  }

  /// Frames that a client lost while the camera got hostile packets, always the same.
  [[nodiscard]] std::uint64_t lost_among_hostile_packets() const;

  std::vector<Frame> rendered_;
  std::unique_ptr<VirtualGigeCamera> camera_;
};

std::uint64_t HostileNetwork::lost_among_hostile_packets() const {
  const auto source = open();
  source->start();
  Frame frame(source->format());
  while (source->next(frame, 100ms) != Arrival::frame) {
  }
  const std::uint64_t first = frame.stamp.sequence;
  std::atomic<int> sent = 0, unanswered = 0;
  std::jthread hostile([&](const std::stop_token& stop) {
    const ClientSocket sender;
    std::mt19937 random(18);
    Bytes last;
    for (int i = 0; i < packets_wanted() && !stop.stop_requested(); ++i, ++sent) {
      Bytes packet = random() % 16 == 0 ? last : hostile_packet(random);
      sender.send(packet, camera_port);
      last = std::move(packet);
      if (i % 32 == 0 && ask(sender, command(read_register, {0xa00}, 0xbeef)).empty()) ++unanswered;
    }
  });
  std::uint64_t frames = 1;
  while (sent < packets_wanted() || frames < 100) {
    // On a busy machine frames may come damaged, which the counters say.
    const Arrival arrival = source->next(frame, 2s);
    if (arrival == Arrival::damaged) continue;
    if (arrival != Arrival::frame) break;
    ++frames;
    EXPECT_TRUE(same_pixels(frame, rendered_[frame.stamp.sequence % 4])) << frame.stamp.sequence;
  }
  EXPECT_EQ(sent, packets_wanted());
  EXPECT_EQ(unanswered, 0);
  EXPECT_EQ(source->counters().reconnects, 0U);

  const std::uint64_t lost = frame.stamp.sequence + 1 - first - frames;
  EXPECT_GE(source->counters().lost, lost);
  return lost;
}

// A packet that costs a frame costs it each time; a busy machine does not.
TEST_F(HostileNetwork, NoPacketEndsTheServedCameraOrCostsItsClientAFrame) {
  std::uint64_t lost = lost_among_hostile_packets();
  for (int again = 0; again < 2 && lost > 0; ++again) lost = lost_among_hostile_packets();
  EXPECT_EQ(lost, 0U);
}

/// A malformed stream packet: parts out of order, from past or future frames, with other payload
/// types, with extreme sizes, or truncated.
Bytes hostile_frame_packet(std::mt19937& random) {
  Bytes packet(random() % 72);
  for (std::uint8_t& byte : packet) byte = static_cast<std::uint8_t>(random());
  if (packet.size() < 8) return packet;
  if (random() % 8 != 0) packet[0] = packet[1] = 0;         // success
  if (random() % 2 == 0) packet[2] = 0;                     // one of the first frames
  packet[4] = static_cast<std::uint8_t>(1 + random() % 3);  // leader, trailer or pixels
  if (random() % 16 == 0) packet[4] |= 0x80;                // extended IDs
  if (random() % 4 != 0) packet[5] = packet[6] = 0;         // among the first packets
  if (packet[4] == 1 && random() % 4 != 0) {
    packet.resize(8 + 36);
    packet[8] = packet[9] = packet[10] = 0;
    packet[11] = static_cast<std::uint8_t>(1 + random() % 8);  // image or other payload type
  }
  return packet;
}

TEST_F(HostileNetwork, NoPictureInItsNameEndsTheClient) {
  const auto source = open();
  source->start();
  Frame frame(source->format());
  while (source->next(frame, 100ms) != Arrival::frame) {
  }
  const ClientSocket sender;
  const Bytes port = ask(sender, command(read_register, {0xd00}));
  ASSERT_EQ(port.size(), 12U);
  std::mt19937 random(18);
  for (int i = 0; i < packets_wanted(); ++i) {
    sender.send(hostile_frame_packet(random), static_cast<std::uint16_t>(port[10] << 8 | port[11]));
    if (i % 32 == 0) (void)source->next(frame, 1ms);
  }
  // Forged packets can cause wrong frames, but correct ones must follow.
  int right = 0;
  for (const auto end = steady_clock::now() + 20s; right < 20 && steady_clock::now() < end;) {
    const bool came = source->next(frame, 100ms) == Arrival::frame;
    const bool is_right = came && same_pixels(frame, rendered_[frame.stamp.sequence % 4]);
    right = is_right ? right + 1 : came ? 0 : right;
  }
  EXPECT_EQ(right, 20);
}

/// A valid image packet, or one that noise extends beyond the agreed size.
Bytes stray_packet(const GigeBlock& block, std::mt19937& random) {
  Bytes packet;
  write_packet(block, random() % packet_count(block), packet);
  if (random() % 4 != 0) return packet;
  const std::size_t agreed = 8 + block.packet_bytes;
  while (packet.size() < agreed) packet.push_back(static_cast<std::uint8_t>(random()));
  for (std::size_t more = 1 + random() % 2000; more > 0; --more) {
    packet.push_back(static_cast<std::uint8_t>(random()));
  }
  return packet;
}

TEST_F(HostileNetwork, PacketsAgainEarlyLateAndTooLongGiveNoWrongFrame) {
  const auto source = open();
  source->start();
  Frame frame(source->format());
  while (source->next(frame, 100ms) != Arrival::frame) {
  }
  const ClientSocket sender;
  const Bytes port = ask(sender, command(read_register, {0xd00}));
  ASSERT_EQ(port.size(), 12U);
  GigeStream stream{};
  stream.region.size = source->format().size;
  stream.packet_bytes = 8000 - 36;
  std::mt19937 random(18);
  int frames = 0;
  for (int i = 0; i < packets_wanted() || frames < 100; ++i) {
    const std::uint64_t other = frame.stamp.sequence + random() % 6;  // 3 past, current, 2 future
    const std::uint64_t sequence = other < 3 ? 0 : other - 3;
    const auto& picture = std::get<Image<std::uint8_t>>(rendered_[sequence % 4].pixels);
    const GigeBlock block = block_of(picture, stream, static_cast<std::uint16_t>(sequence + 1));
    sender.send(stray_packet(block, random), static_cast<std::uint16_t>(port[10] << 8 | port[11]));
    if (i % 16 != 0 || source->next(frame, 1ms) != Arrival::frame) continue;
    ++frames;
    ASSERT_TRUE(same_pixels(frame, rendered_[frame.stamp.sequence % 4])) << frame.stamp.sequence;
  }
}

}  // namespace slipstream::hostile_network_test
