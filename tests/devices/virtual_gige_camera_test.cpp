// The virtual camera sends frames over UDP on loopback; the client must receive the same frames.
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "devices/genicam.h"
#include "devices/gige_protocol.h"
#include "devices/gige_sockets.h"
#include "frames/mosaic.h"
#include "simulate/rendered_reel.h"
#include "slipstream/camera.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/virtual_scanner.h"
#include "tests/devices/gvcp_packets.h"
#include "tests/devices/served_camera.h"
#include "tests/io/expect_error.h"
#include "tests/recording/recorded_frames.h"

extern "C" {  // of Aravis
void arv_enable_interface(const char* name);
void arv_disable_interface(const char* name);
}

namespace slipstream::virtual_gige_camera_test {
using namespace std::chrono_literals;
using std::chrono::steady_clock;

constexpr int loopback_packets = 8000;

std::vector<Frame> frames_of_scan(const Scanner& scanner, const Strategy& strategy) {
  const FrameSet set = take_scan(scanner, scene_named("statue", scanner),
                                 pattern_set(strategy, Axis::x), {.noise_variance = 1.55})
                           .frames;
  std::vector<Frame> frames;
  set.visit([&](const auto& views) {
    for (const auto& view : views) {
      Frame& frame = frames.emplace_back(FrameFormat{set.size(), 8});
      auto& image = std::get<Image<std::uint8_t>>(frame.pixels);
      for_each_pixel_in_order(set.size(), [&](int column, int row) {
        image(column, row) = static_cast<std::uint8_t>(view(column, row));
      });
    }
  });
  return frames;
}

std::vector<Frame> some_frames(int count, Size size = {640, 480}) {
  std::vector<Frame> frames;
  for (int i = 0; i < count; ++i) frames.push_back(some_frame(i, {size, 8}));
  return frames;
}

CameraSettings settings_at(double rate, int cycle) {
  return {.frame_rate = rate, .packet_size = loopback_packets, .cycle = cycle};
}

/// Gets the next frame; false if none arrives within `longest`.
bool wait_for_frame(FrameSource& source, Frame& frame, std::chrono::seconds longest = 5s) {
  const auto end = steady_clock::now() + longest;
  while (steady_clock::now() < end) {
    if (source.next(frame, 100ms) == Arrival::frame) return true;
  }
  return false;
}

bool same_bits(const Cloud& a, const Cloud& b) {
  const auto same = [](const Image<float>& one, const Image<float>& other) {
    return one.size() == other.size() &&
           std::memcmp(one.begin(), other.begin(), one.pixel_count() * sizeof(float)) == 0;
  };
  return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z) && same(a.intensity, b.intensity);
}

int frames_wanted() {
  const char* asked = std::getenv("SLIPSTREAM_CAMERA_FRAMES");
  return asked == nullptr ? 600 : std::atoi(asked);
}

TEST(VirtualGigeCamera, EveryFrameArrivesAsItWasRenderedAndGivesTheCloudOfTheOfflineScan) {
  const Scanner scanner = example_scanner({640, 480});
  const Strategy strategy = PhaseMeasuring{.steps = 4, .frequency = 1};
  const std::vector<Frame> rendered = frames_of_scan(scanner, strategy);
  const auto camera = serve(rendered);
  REQUIRE_CAMERA(camera);
  Engine engine(scanner, {.strategy = strategy});
  const auto cloud_of = [&](const std::vector<Frame>& frames) {
    Frames<std::uint8_t> views;
    for (const Frame& frame : frames) views.push_back(std::get<0>(frame.pixels));
    Cloud cloud;
    engine.cloud(views, cloud);
    return cloud;
  };
  const Cloud offline = cloud_of(rendered);

  const auto opened = open_genicam_camera(served_address, settings_at(200, 4));
  FrameSource& source = *opened;
  EXPECT_EQ(source.format(), (FrameFormat{{640, 480}, 8}));
  source.start();
  std::vector<Frame> window(4);
  Frame frame(source.format());
  ASSERT_TRUE(wait_for_frame(source, frame));
  const std::uint64_t first = frame.stamp.sequence;
  EXPECT_LT(first, 3U);
  const int wanted = frames_wanted();
  for (int i = 0; i < wanted; ++i) {
    if (i > 0) {
      ASSERT_TRUE(wait_for_frame(source, frame));
    }
    ASSERT_EQ(frame.stamp.sequence, first + static_cast<std::uint64_t>(i)) << "a frame was lost";
    const std::size_t pattern = frame.stamp.sequence % 4;
    ASSERT_TRUE(same_pixels(frame, rendered[pattern])) << frame.stamp.sequence;
    window[pattern] = frame;
    if (i % 100 == 99) {
      EXPECT_TRUE(same_bits(cloud_of(window), offline));
    }
  }
  source.stop();
  EXPECT_EQ(source.counters().delivered, static_cast<std::uint64_t>(wanted));
  EXPECT_EQ(source.counters().lost, 0U);
  EXPECT_EQ(source.counters().reconnects, 0U);
  EXPECT_EQ(source.state(), "");
}

TEST(VirtualGigeCamera, TheNextReelIsForWhoComesAfterTheFirstWasSeenWhole) {
  const std::vector<Frame> rendered = some_frames(3, {320, 240});
  const auto camera = serve(VirtualGigeCamera::Reels{
      std::make_shared<RenderedReel>(Reel{{rendered[0], rendered[1]}, {0, 0, 1, 0}, 4}),
      std::make_shared<RenderedReel>(reel_of({rendered[2]}))});
  REQUIRE_CAMERA(camera);
  const auto see = [&](std::uint64_t frames) {
    const auto opened = open_genicam_camera(served_address, settings_at(100, 4));
    FrameSource& source = *opened;
    source.start();
    Frame frame(source.format());
    do {
      if (!wait_for_frame(source, frame)) return frame;
    } while (frame.stamp.sequence + 1 < frames);
    return frame;
  };
  EXPECT_FALSE(same_pixels(see(2), rendered[2]));
  const Frame whole = see(7);  // the first client left too early
  EXPECT_TRUE(same_pixels(whole, rendered[whole.stamp.sequence % 4 == 2 ? 1 : 0]));
  EXPECT_TRUE(same_pixels(see(2), rendered[2]));
}

TEST(VirtualGigeCamera, AnInvertedStrobeBeginsWithTheLastPatternOfTheReelThatIsShown) {
  const std::vector<Frame> rendered = some_frames(5, {320, 240});
  const auto camera = serve(VirtualGigeCamera::Reels{
      std::make_shared<RenderedReel>(reel_of({rendered[0], rendered[1]})),
      std::make_shared<RenderedReel>(reel_of({rendered[2], rendered[3], rendered[4]}))});
  REQUIRE_CAMERA(camera);
  camera->set_wiring(Wiring::strobe);
  CameraSettings settings = settings_at(100, 3);
  settings.strobe = "Line1";
  settings.strobe_inverted = true;
  const auto first_seen = [&] {
    const auto opened = open_genicam_camera(served_address, settings);
    opened->start();
    Frame frame(opened->format());
    EXPECT_TRUE(wait_for_frame(*opened, frame));
    return frame;
  };
  const Frame of_first_reel = first_seen(), of_second = first_seen();
  EXPECT_TRUE(same_pixels(of_first_reel, rendered[(1 + of_first_reel.stamp.sequence) % 2]));
  EXPECT_TRUE(same_pixels(of_second, rendered[2 + (2 + of_second.stamp.sequence) % 3]));
}

TEST(VirtualGigeCamera, LostPacketsLoseTheirFramesAndSlipNoPattern) {
  const std::vector<Frame> rendered = some_frames(5, {320, 240});
  const auto camera = serve(rendered);
  REQUIRE_CAMERA(camera);
  const auto opened = open_genicam_camera(served_address, settings_at(200, 5));
  FrameSource& source = *opened;
  source.start();
  Frame frame(source.format());
  ASSERT_TRUE(wait_for_frame(source, frame));
  const std::uint64_t first = frame.stamp.sequence;
  camera->set_packet_loss(0.02);
  std::uint64_t newest = 0, whole = 0;
  for (const auto end = steady_clock::now() + 1500ms; steady_clock::now() < end;) {
    if (source.next(frame, 50ms) != Arrival::frame) continue;
    ++whole;
    newest = frame.stamp.sequence;
    ASSERT_TRUE(same_pixels(frame, rendered[newest % 5])) << newest;
  }
  source.stop();
  const SourceCounters counters = source.counters();
  EXPECT_GT(whole, 10U);
  EXPECT_GT(counters.lost, 5U);
  EXPECT_EQ(counters.delivered + counters.lost, newest - first + 1);
}

/// Reads frames until the source reports that its camera is gone, at most 5 s.
void wait_until_gone(FrameSource& source, Frame& frame) {
  for (const auto end = steady_clock::now() + 5s;
       source.state().empty() && steady_clock::now() < end;) {
    (void)source.next(frame, 50ms);
  }
}

class VirtualGigeCameraGoneFor : public testing::TestWithParam<std::chrono::milliseconds> {};

TEST_P(VirtualGigeCameraGoneFor, IsFoundAgainWhenItIsBack) {
  const std::vector<Frame> rendered = some_frames(4, {320, 240});
  auto camera = serve(rendered);
  REQUIRE_CAMERA(camera);
  const auto opened = open_genicam_camera(served_address, settings_at(100, 4));
  FrameSource& source = *opened;
  source.start();
  Frame frame(source.format());
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(wait_for_frame(source, frame));
  const std::uint64_t before = frame.stamp.sequence;

  camera.reset();
  wait_until_gone(source, frame);
  EXPECT_NE(source.state().find("127.0.0.1 is lost; searching for it"), std::string::npos);
  for (const auto end = steady_clock::now() + GetParam(); steady_clock::now() < end;) {
    EXPECT_EQ(source.next(frame, 50ms), Arrival::nothing);
  }

  camera = serve(rendered);
  ASSERT_TRUE(camera);
  const auto back = steady_clock::now();
  ASSERT_TRUE(wait_for_frame(source, frame, 10s));
  const std::chrono::duration<double> seconds = steady_clock::now() - back;
  RecordProperty("seconds_to_resume", std::to_string(seconds.count()));
  EXPECT_EQ(source.state(), "");
  EXPECT_EQ(source.counters().reconnects, 1U);
  EXPECT_GT(frame.stamp.sequence, before + 1);
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(same_pixels(frame, rendered[frame.stamp.sequence % 4])) << frame.stamp.sequence;
    ASSERT_TRUE(wait_for_frame(source, frame));
  }
}

INSTANTIATE_TEST_SUITE_P(VirtualGigeCamera, VirtualGigeCameraGoneFor, testing::Values(0ms, 2500ms));

TEST(VirtualGigeCamera, StartsAgainThoughItWasGoneAtTheStop) {
  const std::vector<Frame> rendered = some_frames(4, {320, 240});
  auto camera = serve(rendered);
  REQUIRE_CAMERA(camera);
  const auto opened = open_genicam_camera(served_address, settings_at(100, 4));
  FrameSource& source = *opened;
  source.start();
  Frame frame(source.format());
  ASSERT_TRUE(wait_for_frame(source, frame));
  camera.reset();
  wait_until_gone(source, frame);
  ASSERT_FALSE(source.state().empty());
  source.stop();
  EXPECT_THROW(source.start(), WorldError);
  camera = serve(rendered);
  ASSERT_TRUE(camera);
  source.start();
  EXPECT_EQ(source.state(), "");
  EXPECT_EQ(source.counters().reconnects, 1U);
  EXPECT_TRUE(wait_for_frame(source, frame));
}

TEST(VirtualGigeCamera, IsTakenBackWhenAnotherClientNoLongerControlsIt) {
  const auto camera = serve(some_frames(4, {160, 120}));
  REQUIRE_CAMERA(camera);
  const auto opened = open_genicam_camera(served_address, {.trigger = "Software", .cycle = 4});
  FrameSource& source = *opened;
  source.start();
  Frame frame(source.format());
  source.trigger();
  ASSERT_TRUE(wait_for_frame(source, frame));

  // As after a stall: the source's control has ended, and another client is faster. The packet that
  // ends it must come from the source's own socket.
  const auto control = static_cast<std::uint32_t>(GigeRegister::control_privilege);
  const Bytes leave = command(write_register, {control, 0});
  const sockaddr_in to = address_of(loopback, camera_port);
  for (const auto& [socket, address] : udp_sockets()) {
    if (ntohs(address.sin_port) == camera_port) continue;
    ::sendto(socket, leave.data(), leave.size(), 0, reinterpret_cast<const sockaddr*>(&to),
             sizeof(to));
  }
  const ClientSocket other;
  other.send(command(write_register, {control, 2}));
  ASSERT_EQ(other.receive().at(1), 0) << "it has no control";

  wait_until_gone(source, frame);
  EXPECT_NE(source.state().find("is lost; searching for it"), std::string::npos);
  for (const auto end = steady_clock::now() + 5s;
       source.state().find("refused") == std::string::npos && steady_clock::now() < end;) {
    (void)source.next(frame, 50ms);
  }
  EXPECT_NE(source.state().find("refused"), std::string::npos) << source.state();

  other.send(command(write_register, {control, 0}));
  for (const auto end = steady_clock::now() + 10s;
       !source.state().empty() && steady_clock::now() < end;) {
    (void)source.next(frame, 50ms);
  }
  EXPECT_EQ(source.counters().reconnects, 1U);
  source.trigger();
  EXPECT_TRUE(wait_for_frame(source, frame));
}

TEST(VirtualGigeCamera, OneOfAnotherSizeIsNotTakenForTheOneThatWasLost) {
  auto camera = serve(some_frames(4, {320, 240}));
  REQUIRE_CAMERA(camera);
  const auto opened = open_genicam_camera(served_address, settings_at(100, 4));
  FrameSource& source = *opened;
  source.start();
  Frame frame(source.format());
  ASSERT_TRUE(wait_for_frame(source, frame));
  camera.reset();
  camera = serve(some_frames(4, {160, 120}));
  ASSERT_TRUE(camera);
  for (const auto end = steady_clock::now() + 3s; steady_clock::now() < end;) {
    const Arrival arrival = source.next(frame, 50ms);
    if (arrival == Arrival::frame) {
      EXPECT_EQ(frame.format().size, (Size{320, 240}));
    }
  }
  EXPECT_EQ(source.counters().reconnects, 0U);
  EXPECT_FALSE(source.state().empty());
}

TEST(VirtualGigeCamera, GivesTheRegionThatIsAskedFor) {
  const std::vector<Frame> rendered = some_frames(3, {320, 240});
  const auto camera = serve(rendered);
  REQUIRE_CAMERA(camera);
  CameraSettings settings = settings_at(100, 3);
  settings.region = Rectangle{16, 8, {64, 32}};
  const auto opened = open_genicam_camera(served_address, settings);
  FrameSource& source = *opened;
  EXPECT_EQ(source.format().size, (Size{64, 32}));
  source.start();
  Frame frame(source.format());
  ASSERT_TRUE(wait_for_frame(source, frame));
  const auto& part = std::get<0>(frame.pixels);
  const auto& whole = std::get<0>(rendered[frame.stamp.sequence % 3].pixels);
  for (int row = 0; row < 32; ++row) {
    for (int column = 0; column < 64; ++column) {
      ASSERT_EQ(part(column, row), whole(16 + column, 8 + row)) << column << ", " << row;
    }
  }
}

TEST(VirtualGigeCamera, TakesAFrameForEachSoftwareTrigger) {
  const auto camera = serve(some_frames(4, {160, 120}));
  REQUIRE_CAMERA(camera);
  CameraSettings settings{.exposure = 0.002, .gain = 3, .trigger = "Software", .cycle = 4};
  const auto opened = open_genicam_camera(served_address, settings);
  FrameSource& source = *opened;
  source.start();
  Frame frame(source.format());
  EXPECT_EQ(source.next(frame, 700ms), Arrival::nothing);
  EXPECT_EQ(source.state(), "") << "a camera that waits for its trigger is not gone";
  for (std::uint64_t i = 0; i < 8; ++i) {
    source.trigger();
    ASSERT_TRUE(wait_for_frame(source, frame));
    EXPECT_EQ(frame.stamp.sequence, i);
  }
}

TEST(VirtualGigeCamera, GoesOnWhenTheProjectorFallsBack) {
  const auto camera = serve(some_frames(4, {160, 120}));
  REQUIRE_CAMERA(camera);
  camera->set_wiring(Wiring::trigger);
  camera->set_frame_rate(1000);
  const auto opened = open_genicam_camera(served_address, settings_at(100, 4));
  opened->start();
  Frame frame(opened->format());
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(wait_for_frame(*opened, frame)) << i;
    if (i == 10) camera->set_frame_rate(20);  // fewer patterns are shown since the start
  }
}

TEST(VirtualGigeCamera, StalledConsumerLosesFramesAndGoesOn) {
  const std::vector<Frame> rendered = some_frames(4, {160, 120});
  const auto camera = serve(rendered);
  REQUIRE_CAMERA(camera);
  const auto opened = open_genicam_camera(served_address, settings_at(200, 4));
  FrameSource& source = *opened;
  source.start();
  Frame frame(source.format());
  ASSERT_TRUE(wait_for_frame(source, frame));
  std::this_thread::sleep_for(600ms);
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(wait_for_frame(source, frame));
    ASSERT_TRUE(same_pixels(frame, rendered[frame.stamp.sequence % 4]));
  }
  EXPECT_GT(source.counters().lost, 20U);
  EXPECT_EQ(source.counters().reconnects, 0U);
}

TEST(VirtualGigeCamera, IsListed) {
  const auto camera = serve(some_frames(1, {160, 120}), "LISTED");
  REQUIRE_CAMERA(camera);
  const std::vector<CameraDescription> cameras = list_cameras();
  const auto found = std::ranges::find(cameras, "LISTED", &CameraDescription::serial);
  ASSERT_NE(found, cameras.end());
  EXPECT_EQ(found->name, "aravis:Aravis-Fake-LISTED");
  EXPECT_EQ(found->address, served_address);
  EXPECT_NO_THROW(open_camera(found->name, {}));
}

TEST(VirtualGigeCamera, SecondOneAtAnAddressIsRefused) {
  const auto camera = serve(some_frames(1, {16, 16}));
  REQUIRE_CAMERA(camera);
  try {
    const VirtualGigeCamera second(some_frames(1), served_address, "SECOND");
    ADD_FAILURE() << "two cameras at one address";
  } catch (const WorldError& error) {
    EXPECT_NE(std::string(error.what()).find("3956"), std::string::npos) << error.what();
  }
}

TEST(VirtualGigeCamera, RefusesWhatItCannotServe) {
  expect_error([] { VirtualGigeCamera(std::vector<Frame>{}, served_address, "S"); },
               {"at least one frame"});
  expect_error([] { VirtualGigeCamera(some_frames(1), "here", "S"); }, {"here", "127.0.0.1"});
  expect_error([] { VirtualGigeCamera(some_frames(1), served_address, ""); }, {"serial"});
  expect_error([] { VirtualGigeCamera({Frame({{4, 4}, 12})}, served_address, "S"); }, {"8-bit"});
}

TEST(VirtualGigeCamera, GenICamCameraGivesColoursSideBySide) {
  arv_enable_interface("Fake");  // Aravis's fake camera, without a network
  const auto source = open_genicam_camera(
      "Fake_1", {.region = Rectangle{.size = {64, 48}}, .pixel_format = PixelFormat::rgb8});
  EXPECT_EQ(source->format(), (FrameFormat{{192, 48}, 8}));
  source->start();
  Frame frame(source->format());
  ASSERT_EQ(source->next(frame, 10s), Arrival::frame);
  const auto& values = std::get<Image<std::uint8_t>>(frame.pixels);
  // A moving ramp whose green differs from its red and blue.
  EXPECT_NE(values(30, 20), values(31, 20));
  EXPECT_EQ(values(33, 20), static_cast<std::uint8_t>(values(30, 20) + 4));
  source->stop();
  arv_disable_interface("Fake");
}

TEST(VirtualGigeCamera, GenICamCameraMakesAMosaicGrey) {
  const auto frames = some_frames(1, {64, 48});
  const auto camera = serve(frames);
  REQUIRE_CAMERA(camera);
  CameraSettings settings = settings_at(50, 1);
  set_pixel_format(settings, "BayerRG8");
  const auto source = open_genicam_camera(served_address, settings);
  source->start();
  Frame frame(source->format()), grey = frames.front();
  ASSERT_EQ(source->next(frame, 10s), Arrival::frame);
  source->stop();
  make_grey(grey);
  EXPECT_TRUE(same_pixels(frame, grey));
}

TEST(VirtualGigeCamera, GenICamCameraReportsItsTemperatures) {
  const auto camera = serve(some_frames(1, {64, 48}));
  REQUIRE_CAMERA(camera);
  const auto source = open_genicam_camera(served_address, {});
  EXPECT_EQ(temperatures_of(*source), (Temperatures{{"Mainboard", 38}, {"Sensor", 41}}));
}

TEST(VirtualGigeCamera, GenICamCameraSaysWhatItCannotDo) {
  EXPECT_THROW(open_genicam_camera("no such camera", {}), WorldError);
  const auto camera = serve(some_frames(1, {160, 120}));
  REQUIRE_CAMERA(camera);
  expect_error(
      [] { (void)open_genicam_camera(served_address, {.pixel_format = PixelFormat::mono12p}); },
      {"127.0.0.1", "Mono12p"});
  expect_error([] { (void)open_genicam_camera(served_address, {.cycle = 0}); }, {"0 patterns"});
}

}  // namespace slipstream::virtual_gige_camera_test
