// Who sends what no camera and no client would: at the served camera while a client streams, and at
// the client while a camera serves it.
#include <atomic>
#include <cstdlib>
#include <thread>

#include <gtest/gtest.h>

#include "slipstream/camera/detail/udp_socket.h"
#include "slipstream/camera/genicam.h"
#include "slipstream/camera/virtual_gige_camera.h"
#include "slipstream/error/error.h"
#include "tests/camera/gvcp_packets.h"
#include "tests/io/recorded_frames.h"

namespace slipstream {
namespace {
using namespace std::chrono_literals;
using std::chrono::steady_clock;

constexpr std::uint32_t loopback = 0x7f000001;
constexpr UdpAddress camera_address{loopback, 3956};

/// 10^4, or as many as SLIPSTREAM_HOSTILE_PACKETS says.
int packets_wanted() {
  const char* asked = std::getenv("SLIPSTREAM_HOSTILE_PACKETS");
  return asked == nullptr ? 10'000 : std::atoi(asked);
}

/// What the camera answers within a second, other answers aside; empty where it does not.
Bytes ask(const UdpSocket& socket, const Bytes& packet) {
  socket.send(packet, camera_address);
  Bytes room(2048);
  for (const auto end = steady_clock::now() + 1s; steady_clock::now() < end;) {
    UdpAddress from;
    const auto answer = socket.receive(room, from);
    const bool is_answer = answer.size() >= 8 &&
                           std::equal(packet.begin() + 6, packet.begin() + 8, answer.begin() + 6);
    if (is_answer) return {answer.begin(), answer.end()};
    if (answer.empty()) std::this_thread::yield();
  }
  return {};
}

class HostileNetwork : public testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 4; ++i) rendered_.push_back(some_frame(i, {{320, 240}, 8}));
    try {
      camera_ = std::make_unique<VirtualGigeCamera>(rendered_, "127.0.0.1", "HOSTILE");
    } catch (const WorldError&) {
      GTEST_SKIP() << "no camera can be served at 127.0.0.1";
    }
  }
  [[nodiscard]] static std::unique_ptr<FrameSource> open() {
    return open_genicam_camera("127.0.0.1", {.frame_rate = 100, .packet_size = 8000, .cycle = 4});
  }

  std::vector<Frame> rendered_;
  std::unique_ptr<VirtualGigeCamera> camera_;
};

TEST_F(HostileNetwork, NoPacketEndsTheServedCameraOrCostsItsClientAFrame) {
  const auto source = open();
  source->start();
  Frame frame(source->format());
  while (source->next(frame, 100ms) != Arrival::frame) {
  }
  const std::uint64_t first = frame.stamp.sequence;
  std::atomic<int> sent = 0, unanswered = 0;
  std::jthread hostile([&](const std::stop_token& stop) {
    const UdpSocket socket({loopback, 0}, false);
    std::mt19937 random(18);
    Bytes last;
    for (int i = 0; i < packets_wanted() && !stop.stop_requested(); ++i, ++sent) {
      Bytes packet = random() % 16 == 0 ? last : hostile_packet(random);
      socket.send(packet, camera_address);
      last = std::move(packet);
      if (i % 32 == 0 && ask(socket, command(read_register, {0xa00}, 0xbeef)).empty()) ++unanswered;
    }
  });
  std::uint64_t frames = 1;
  while (sent < packets_wanted() || frames < 100) {
    if (source->next(frame, 2s) != Arrival::frame) break;
    ASSERT_EQ(frame.stamp.sequence, first + frames++) << "after " << sent << " hostile packets";
    ASSERT_TRUE(same_pixels(frame, rendered_[frame.stamp.sequence % 4]));
  }
  EXPECT_EQ(sent, packets_wanted());
  EXPECT_EQ(unanswered, 0);
  EXPECT_EQ(source->counters().lost, 0U);
  EXPECT_EQ(source->counters().reconnects, 0U);
  RecordProperty("packets", sent);
  RecordProperty("frames", std::to_string(frames));
}

}  // namespace
}  // namespace slipstream
