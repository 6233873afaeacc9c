// The 3-D camera sink, read by a client written here from the protocol specification.
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <future>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include "base/numbers.h"
#include "devices/gige_protocol.h"
#include "publish/scan3d.h"
#include "slipstream/cloud_sink.h"
#include "slipstream/error.h"
#include "tests/devices/gvcp_packets.h"
#include "tests/publish/any_cloud.h"

namespace slipstream::genicam_test {

template <class Number>
Number big_endian_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return number_at<Number, std::endian::big>(bytes, at);
}
using namespace std::chrono_literals;
using enum GigeRegister;
using enum GigeStatus;
using namespace scan3d;

constexpr std::uint32_t fire_test_packet = 0x80000000, multipart = 0x40;

std::uint32_t bits(float number) {
  return std::bit_cast<std::uint32_t>(number);
}

struct TakenBlock {
  std::uint64_t number = 0;
  Bytes leader, pixels;
  std::vector<Bytes> packets;
};

/// A GigE Vision client.
class Client {
 public:
  /// Sends a packet up to five times, until an answer comes.
  Bytes ask(const Bytes& packet) const {
    for (int i = 0; i < 5; ++i) {
      control.send(packet);
      if (Bytes answer = control.receive(); !answer.empty()) return answer;
    }
    return {};
  }
  GigeStatus write(GigeRegister which, std::uint32_t value) const {
    const Bytes answer = ask(command(write_register, {static_cast<std::uint32_t>(which), value}));
    EXPECT_GE(answer.size(), 8U);
    return static_cast<GigeStatus>(big_endian_at<std::uint16_t>(answer, 0));
  }
  std::uint32_t read(GigeRegister which) const {
    const Bytes answer = ask(command(read_register, {static_cast<std::uint32_t>(which)}));
    EXPECT_EQ(answer.size(), 12U);
    return big_endian_at<std::uint32_t>(answer, 8);
  }
  void open(std::uint32_t packet = 576) const {
    EXPECT_EQ(write(control_privilege, 2), success);
    EXPECT_EQ(write(heartbeat_timeout, 60'000), success);
    EXPECT_EQ(write(stream_host, loopback), success);
    EXPECT_EQ(write(stream_port, stream.port()), success);
    EXPECT_EQ(write(packet_size, packet), success);
    EXPECT_EQ(write(frame_period, 1000), success);
  }
  /// Receives packets up to the end of the next block, or until a timeout.
  TakenBlock take(std::chrono::milliseconds patience = 2s) const {
    TakenBlock block;
    while (true) {
      const Bytes packet = stream.receive(patience);
      if (packet.empty()) return block;
      const bool is_long = (packet[4] & 0x80) != 0;
      const std::uint8_t content = packet[4] & 0x7f;
      const auto body = std::span(packet).subspan(is_long ? 20 : 8);
      block.number = is_long ? big_endian_at<std::uint64_t>(packet, 8)
                             : big_endian_at<std::uint16_t>(packet, 2);
      block.packets.push_back(packet);
      if (content == 1) block.leader.assign(body.begin(), body.end());
      if (content == 3) block.pixels.insert(block.pixels.end(), body.begin(), body.end());
      if (content == 7) {
        EXPECT_EQ(big_endian_at<std::uint32_t>(body, 4), block.pixels.size());
        block.pixels.insert(block.pixels.end(), body.begin() + 8, body.end());
      }
      if (content == 2) return block;
    }
  }

  const ClientSocket stream, control;
};

class GenicamSink : public testing::Test {
 protected:
  void SetUp() override { sink_ = open_sink("genicam:127.0.0.1", run_); }
  /// Publishes cloud `sequence` and returns the block that the client receives.
  TakenBlock put_and_take(const Client& client, std::uint64_t sequence) {
    std::this_thread::sleep_for(1ms);  // the camera sends at most 1000 per second
    sink_->put(any_cloud(sequence), false);
    return client.take();
  }

  std::vector<RunSetting> settings_{
      {.name = "exposure", .help = "", .unit = "ms", .value = "2.5", .least = 0.1, .most = 30},
      {.name = "strategy", .help = "", .value = "b", .choices = {"a", "b"}}};
  std::mutex mutex_;  ///< guards the settings
  PublishedRun run_{.camera = camera(),
                    .settings =
                        [this] {
                          const std::lock_guard lock(mutex_);
                          return settings_;
                        },
                    .change =
                        [this](const std::string& name, const std::string& value) {
                          const std::lock_guard lock(mutex_);
                          require_settable(settings_, name, value);
                          settings_[name == "strategy" ? 1 : 0].value = value;
                        }};
  std::unique_ptr<CloudSink> sink_;
};

Bytes points_of(const Cloud& cloud) {
  Bytes bytes(cloud.z.pixel_count() * 12);
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    const std::array point{cloud.x.begin()[i], cloud.y.begin()[i], cloud.z.begin()[i]};
    std::memcpy(&bytes[12 * i], point.data(), 12);
  }
  return bytes;
}

TEST_F(GenicamSink, GivesEachPointBitForBit) {
  const Client client;
  client.open();
  EXPECT_EQ(client.read(payload_size), 61U * 43 * 12);
  EXPECT_FALSE(sink_->wants(*any_cloud(0))) << "nobody has started it";
  EXPECT_EQ(client.write(acquisition, 1), success);
  EXPECT_TRUE(sink_->wants(*any_cloud(0)));
  for (std::uint64_t i = 1; i < 4; ++i) {
    const TakenBlock block = put_and_take(client, i);
    EXPECT_EQ(block.number, i);
    EXPECT_EQ(block.pixels, points_of(any_cloud(i)->cloud));
    EXPECT_EQ(big_endian_at<std::uint32_t>(block.leader, 12),
              static_cast<std::uint32_t>(GigePixels::coord3d_abc32f));
    EXPECT_EQ(big_endian_at<std::uint32_t>(block.leader, 16), 61U);
    EXPECT_EQ(big_endian_at<std::uint32_t>(block.leader, 20), 43U);
  }
}

TEST_F(GenicamSink, GivesDepthInStepsAndSaysWhereThereIsNone) {
  const Client client;
  client.open();
  EXPECT_EQ(client.write(at(coordinate_scale, 2), bits(0.01F)), access_denied) << "of millimetres";
  EXPECT_EQ(client.write(pixel_format, static_cast<std::uint32_t>(GigePixels::coord3d_c16)),
            success);
  for (const float bad : {0.0F, -1.0F, NAN, INFINITY}) {
    EXPECT_EQ(client.write(at(coordinate_scale, 2), bits(bad)), invalid_parameter);
  }
  EXPECT_EQ(client.write(at(coordinate_scale, 2), bits(0.004F)), success);
  EXPECT_EQ(client.write(at(coordinate_offset, 2), bits(498)), success);
  EXPECT_EQ(client.read(output_mode), projected_c);
  EXPECT_EQ(client.read(at(invalid_value, 2)), bits(0));
  EXPECT_EQ(client.write(left, 11), invalid_parameter) << "beyond the sensor";
  EXPECT_EQ(client.write(width, 40), success);
  EXPECT_EQ(client.write(left, 11), success);
  EXPECT_EQ(client.read(principal_u), bits(19));
  EXPECT_EQ(client.write(acquisition, 1), success);
  const TakenBlock block = put_and_take(client, 5);
  const Pooled<LiveCloud> live = any_cloud(5);
  ASSERT_EQ(block.pixels.size(), 40U * 43 * 2);
  int beyond = 0;
  for (int i = 0; i < 40 * 43; ++i) {
    std::uint16_t steps = 0;
    std::memcpy(&steps, &block.pixels[2 * static_cast<std::size_t>(i)], 2);
    const float z = live->cloud.z(11 + i % 40, i / 40);
    const bool fits = z < 498 + 0.004F * 65535;
    beyond += z >= 498 + 0.004F * 65536 ? 1 : 0;
    ASSERT_EQ(steps == 0, !fits) << z;
    if (steps != 0) ASSERT_NEAR(498 + 0.004F * static_cast<float>(steps), z, 0.0021F);
  }
  EXPECT_GT(beyond, 10) << "farther than 16 bits tell";
}

TEST_F(GenicamSink, GivesIntensityAndConfidenceAloneOrAllAtOnce) {
  const Client client;
  client.open();
  const Pooled<LiveCloud> live = any_cloud(7);
  const Bytes points = points_of(live->cloud);
  Bytes intensity, confidence;
  for (std::size_t i = 0; i < live->cloud.z.pixel_count(); ++i) {
    intensity.push_back(grey_level(live->cloud.intensity.begin()[i]));
    confidence.push_back(std::isnan(live->cloud.z.begin()[i]) ? 0 : 255);
  }
  EXPECT_EQ(client.write(component_enable, 0), success);
  EXPECT_EQ(client.write(at(component_enable, 1), 1), success);
  EXPECT_EQ(client.write(acquisition, 1), success);
  EXPECT_EQ(put_and_take(client, 7).pixels, intensity);
  EXPECT_EQ(client.write(component_enable, 1), access_denied) << "while it runs";
  EXPECT_EQ(client.write(acquisition, 0), success);

  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(client.write(at(component_enable, i), 1), success);
  }
  EXPECT_EQ(client.read(payload_size), points.size()) << "the first alone";
  EXPECT_EQ(client.write(stream_configuration, multipart), success);
  EXPECT_EQ(client.read(payload_size), 61U * 43 * 14);
  EXPECT_EQ(client.write(acquisition, 1), success);
  const TakenBlock block = put_and_take(client, 7);
  Bytes all = points;
  all.insert(all.end(), intensity.begin(), intensity.end());
  all.insert(all.end(), confidence.begin(), confidence.end());
  EXPECT_EQ(block.pixels, all);
  EXPECT_EQ(block.packets.front()[7], 3) << "parts";
  for (const Bytes& packet : block.packets) EXPECT_LE(packet.size(), 576U - 28);
}

TEST_F(GenicamSink, SendsAgainWhatWasLostAndNoMoreThanABlock) {
  const Client client;
  client.open();
  for (const bool is_multipart : {false, true}) {
    EXPECT_EQ(client.write(stream_configuration, is_multipart ? multipart : 0), success);
    EXPECT_EQ(client.write(acquisition, 1), success);
    const TakenBlock first = put_and_take(client, 1), block = put_and_take(client, 2);
    const auto resend = [&](std::uint64_t number, std::uint32_t from, std::uint32_t to) {
      const auto low = static_cast<std::uint32_t>(number);
      Bytes packet =
          is_multipart ? command(0x40, {0, from, to, 0, low}) : command(0x40, {low, from, to});
      packet[1] = is_multipart ? 0x10 : 0;
      client.stream.send(packet);
    };
    for (const TakenBlock* each : {&first, &block}) {
      resend(each->number, 0, 2);
      for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(client.stream.receive(), each->packets[i]);
    }
    resend(block.number + 1, 4, 9);
    EXPECT_EQ(big_endian_at<std::uint16_t>(client.stream.receive(), 0), 0x800c);
    for (int i = 0; i < 100; ++i) resend(block.number, 0, 0xffffffff);
    std::size_t again = 3;
    while (!client.stream.receive(100ms).empty()) ++again;
    EXPECT_EQ(again, block.packets.size());
    EXPECT_EQ(client.write(acquisition, 0), success);
  }
  const ClientSocket elsewhere(loopback + 1);
  elsewhere.send(command(0x40, {1, 0, 2}));
  EXPECT_TRUE(client.stream.receive(100ms).empty());
}

TEST_F(GenicamSink, TakesTheNextCloudWhenItIsTriggered) {
  const Client client;
  client.open();
  EXPECT_EQ(client.write(trigger_mode, 1), success);
  EXPECT_EQ(client.write(acquisition, 1), success);
  EXPECT_FALSE(sink_->wants(*any_cloud(1)));
  const Pooled<LiveCloud> before = any_cloud(2);
  EXPECT_EQ(client.write(software_trigger, 1), success);
  EXPECT_FALSE(sink_->wants(*before)) << "its frames are older than the trigger";
  EXPECT_EQ(put_and_take(client, 3).pixels, points_of(any_cloud(3)->cloud));
  EXPECT_FALSE(sink_->wants(*any_cloud(4)));
  EXPECT_EQ(client.write(acquisition, 0), success);
  EXPECT_EQ(client.write(trigger_mode, 0), success);
  EXPECT_EQ(client.write(acquisition_mode, 2), success);
  EXPECT_EQ(client.write(acquisition, 1), success);
  EXPECT_EQ(put_and_take(client, 5).number, 2U);
  EXPECT_EQ(client.read(acquisition), 0U) << "one cloud";
}

TEST_F(GenicamSink, RefusesWhatItCannotDo) {
  const Client client, other;
  EXPECT_EQ(client.write(width, 8), access_denied) << "nobody has control";
  client.open();
  EXPECT_EQ(other.write(control_privilege, 2), access_denied);
  EXPECT_EQ(other.write(acquisition, 1), access_denied);
  EXPECT_EQ(other.read(width), 61U) << "anybody may look";
  const std::vector<std::pair<GigeRegister, std::uint32_t>> bad{
      {width, 0},
      {width, 62},
      {height, 0xffffffff},
      {top, 1},
      {acquisition, 2},
      {trigger_source, 0},
      {frame_period, 0},
      {frame_period, 0xffffffff},
      {packet_size, 0},
      {packet_size, 0xffff},
      {stream_configuration, 1},
      {component_selector, 3},
      {component_enable, 2},
      {output_mode, 0},
      {acquisition_mode, 0},
      {pixel_format, static_cast<std::uint32_t>(GigePixels::mono8)},
      {at(pixel_format, 1), static_cast<std::uint32_t>(GigePixels::coord3d_c16)}};
  for (const auto& [which, value] : bad) {
    EXPECT_EQ(client.write(which, value), invalid_parameter)
        << std::hex << static_cast<std::uint32_t>(which) << " " << value;
  }
  for (const auto which : {sensor_width, payload_size, focal_length, invalid_value}) {
    EXPECT_EQ(client.write(which, 1), write_protected);
  }
  for (const std::uint32_t bytes : {576U, 1500U, 9000U, 65500U}) {
    EXPECT_EQ(client.write(packet_size, fire_test_packet | bytes), success);
    EXPECT_EQ(client.stream.receive().size(), bytes - 28);
    EXPECT_EQ(client.read(packet_size), bytes);
  }
}

TEST_F(GenicamSink, ChangesSettingsOfTheRunAndShowsWhatOthersChanged) {
  const Client client;
  client.open();
  const auto wait_for = [&](GigeRegister which, std::uint32_t value) {
    for (int i = 0; i < 200 && client.read(which) != value; ++i) std::this_thread::sleep_for(50ms);
    EXPECT_EQ(client.read(which), value);
  };
  wait_for(setting, bits(2500));  // us
  wait_for(at(setting, 1), 1);
  EXPECT_EQ(client.write(setting, bits(1234.5F)), success);
  EXPECT_EQ(client.write(at(setting, 1), 0), success);
  EXPECT_EQ(run_.settings()[0].value, "1.2345");
  EXPECT_EQ(run_.settings()[1].value, "a");
  for (const float bad : {0.0F, 30001.0F, NAN}) {
    EXPECT_EQ(client.write(setting, bits(bad)), invalid_parameter);
  }
  EXPECT_EQ(client.write(at(setting, 1), 2), invalid_parameter);
  EXPECT_EQ(client.write(at(setting, 2), 0), invalid_address);
  run_.change("exposure", "7");
  wait_for(setting, bits(7000));
}

TEST_F(GenicamSink, LetsASilentClientGoAndSaysSoOnce) {
  for (int i = 0; i < 2; ++i) {
    const Client client;
    client.open();
    EXPECT_EQ(client.write(component_enable, 0), success);
    EXPECT_EQ(client.write(acquisition, 1), success);
    EXPECT_TRUE(sink_->wants(*any_cloud(0)));
    EXPECT_EQ(client.write(heartbeat_timeout, 500), success);
    while (sink_->wants(*any_cloud(0))) std::this_thread::sleep_for(10ms);
    EXPECT_EQ(sink_->news().size(), i == 0 ? 1U : 0U);
    EXPECT_EQ(client.read(component_enable), 1U) << "the next finds it as it was";
  }
}

TEST_F(GenicamSink, SendsCloudsWhileTheRunTakesLongForAChange) {
  std::promise<void> may_end;
  std::atomic<bool> changing = false;
  run_.change = [&](const std::string&, const std::string&) {
    changing = true;
    may_end.get_future().wait_for(10s);
    changing = false;
  };
  sink_.reset();
  SetUp();
  const Client client;
  client.open();
  EXPECT_EQ(client.write(heartbeat_timeout, 500), success);
  EXPECT_EQ(client.write(acquisition, 1), success);
  client.control.send(command(write_register, {static_cast<std::uint32_t>(setting), bits(2000)}));
  std::this_thread::sleep_for(800ms);  // heartbeats would wait for the change
  EXPECT_EQ(put_and_take(client, 1).pixels, points_of(any_cloud(1)->cloud));
  EXPECT_TRUE(changing);
  may_end.set_value();
  EXPECT_FALSE(client.control.receive().empty());
  sink_.reset();  // before what its run uses
}

/// A camera whose clients can record.
class GenicamRecording : public GenicamSink {
 protected:
  void SetUp() override {
    settings_.push_back({.name = "record", .help = "", .value = "off", .choices = {"off", "on"}});
    run_.change = [this](const std::string&, const std::string& value) {
      const std::lock_guard lock(mutex_);
      settings_[2].value = value;
    };
    GenicamSink::SetUp();
  }
  [[nodiscard]] std::string recording() {
    const std::lock_guard lock(mutex_);
    return settings_[2].value;
  }
  void wait_for_end() {
    while (recording() == "on") std::this_thread::sleep_for(10ms);
  }
};

TEST_F(GenicamRecording, EndsWhenItsClientGivesUpControl) {
  const Client client;
  client.open();
  EXPECT_EQ(client.write(at(setting, 2), 1), success);
  EXPECT_EQ(recording(), "on");
  EXPECT_EQ(client.write(control_privilege, 0), success);
  wait_for_end();
}

TEST_F(GenicamRecording, EndsWhenItsClientFallsSilent) {
  const Client client;
  client.open();
  EXPECT_EQ(client.write(at(setting, 2), 1), success);
  EXPECT_EQ(client.write(heartbeat_timeout, 500), success);
  wait_for_end();
}

TEST_F(GenicamRecording, GoesOnIfOthersStartedIt) {
  run_.change("record", "on");
  const Client client;
  client.open();
  while (client.read(at(setting, 2)) == 0) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(client.write(at(setting, 2), 1), success);
  EXPECT_EQ(client.write(control_privilege, 0), success);
  std::this_thread::sleep_for(300ms);
  EXPECT_EQ(recording(), "on");
}

TEST_F(GenicamSink, NoPacketEndsItOrCostsItsClientABlock) {
  const Client client;
  client.open();
  EXPECT_EQ(client.write(acquisition, 1), success);
  std::atomic<int> sent = 0;
  constexpr int packets = 100'000;
  std::jthread hostile([&](const std::stop_token& stop) {
    const ClientSocket near, far(loopback + 1);
    std::mt19937 random(23);
    Bytes last;
    for (; sent < packets && !stop.stop_requested(); ++sent) {
      Bytes packet = random() % 16 == 0 ? last : hostile_packet(random);
      (random() % 2 == 0 ? near : far).send(packet);
      last = std::move(packet);
    }
  });
  std::uint64_t blocks = 0;
  while (sent < packets || blocks < 50) {
    const TakenBlock block = put_and_take(client, blocks);
    ASSERT_EQ(block.pixels, points_of(any_cloud(blocks)->cloud)) << "after " << sent;
    if (++blocks % 16 == 0) ASSERT_EQ(client.read(control_privilege), 2U);
  }
  RecordProperty("blocks", std::to_string(blocks));
}

/// The client in control may send anything; the next client finds the camera working.
TEST_F(GenicamSink, ItsOwnClientMaySendAnything) {
  std::mt19937 random(3);
  const Client client;
  const auto any = [&](std::uint32_t small) {
    return static_cast<std::uint32_t>(random() % 2 == 0 ? random() % small : random());
  };
  for (int i = 0; i < 10'000; ++i) {
    if (i % 64 == 0) client.control.send(command(write_register, {0xa00, 2}));
    const std::uint32_t where = random() % 2 == 0 ? 0x8000 + 4 * any(40) : 0x100 + 4 * any(16);
    client.control.send(i % 2 == 0 ? hostile_packet(random)
                                   : command(write_register, {where, any(4)}));
    if (i % 512 == 0) sink_->put(any_cloud(0), false);
    if (i % 4 == 0) std::this_thread::sleep_for(100us);  // gives the camera time to read all
  }
  const Client next;
  while (next.write(control_privilege, 2) != success) {  // it reads the earlier packets first
    client.control.send(command(write_register, {0xa00, 0}));
  }
  next.open();
  EXPECT_EQ(next.write(acquisition, 1), success);
  EXPECT_EQ(put_and_take(next, 1).pixels, points_of(any_cloud(1)->cloud));
}

TEST(GenicamSinkName, IsAnAddressOfThisMachine) {
  EXPECT_NO_THROW(require_sink("genicam:127.0.0.1"));
  for (const char* bad : {"genicam:x", "genicam:3956", "genicam:127.0.0.1:3956", "genicam:::1"}) {
    EXPECT_THROW(require_sink(bad), Error) << bad;
  }
  EXPECT_THROW(open_sink("genicam:127.0.0.1", {.has_points = false}), Error);
  EXPECT_THROW(open_sink("genicam:192.0.2.1", {.camera = camera()}), WorldError);
}

}  // namespace slipstream::genicam_test
