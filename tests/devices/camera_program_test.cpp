// Runs `slipstream record` against `slipstream camera serve`.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "slipstream/recording.h"
#include "tests/app/program.h"
#include "tests/devices/served_camera.h"
#include "tests/io/temporary_folder.h"
#include "tests/recording/recorded_frames.h"

namespace slipstream::camera_program_test {
namespace fs = std::filesystem;
using namespace std::chrono_literals;

const std::vector<std::string> small_scan{"--strategy", "pmp", "--steps", "4"};

std::vector<std::string> with(std::vector<std::string> arguments,
                              const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

class CameraProgram : public testing::Test {
 protected:
  void SetUp() override { REQUIRE_CAMERA(slipstream::serve(std::vector<Frame>{some_frame(0)})); }

  [[nodiscard]] RunningProgram serve(const std::vector<std::string>& more = {}) const {
    return RunningProgram(with(with({"camera", "serve", "--camera", "160x120", "--scene", "sphere",
                                     "--cycles", "3", "--serial", "PROGRAM"},
                                    small_scan),
                               more));
  }
  [[nodiscard]] RunningProgram record(const std::vector<std::string>& more) const {
    return RunningProgram(
        with({"record", "--source", "aravis:127.0.0.1", "-o", recording(), "--rate", "100"},
             with(small_scan, more)));
  }
  [[nodiscard]] std::string recording() const { return folder_.path() / "frames.slip"; }

  /// Whether the recording grows to so many frames and one more in part.
  [[nodiscard]] bool wait_for_frames(std::uintmax_t count) const {
    return wait_until([&] {
      std::error_code none;
      const std::uintmax_t size = fs::file_size(recording(), none);
      return !none && size > (count + 1) * 160 * 120;
    });
  }

  TemporaryFolder folder_;
};

TEST_F(CameraProgram, RecordsWhatTheOtherServes) {
  RunningProgram server = serve();
  ASSERT_TRUE(server.wait_for_words("serving pmp of 160x120")) << server.words();
  RunningProgram client = record({"--frames", "50", "--json"});
  EXPECT_EQ(client.wait(), 0) << client.words();
  EXPECT_NE(client.words().find("\"frames\": 50"), std::string::npos) << client.words();
  server.send(SIGINT);
  EXPECT_EQ(server.wait(), 0) << server.words();

  const RecordingReader reader(recording());
  EXPECT_TRUE(reader.finished());
  ASSERT_EQ(reader.count(), 50U);
  EXPECT_EQ(reader.header().frame_rate, 100);
  // Three looping scans: frames twelve apart are equal, adjacent ones differ.
  std::vector<Frame> frames(50);
  for (std::uint64_t i = 0; i < 50; ++i) ASSERT_TRUE(reader.read(i, frames[i]));
  for (std::size_t i = 12; i < 50; ++i) {
    const bool whole_round = frames[i].stamp.sequence == frames[i - 12].stamp.sequence + 12;
    EXPECT_TRUE(!whole_round || same_pixels(frames[i], frames[i - 12])) << i;
    EXPECT_FALSE(same_pixels(frames[i], frames[i - 1])) << i;
  }
}

TEST_F(CameraProgram, ServerThatIsKilledAndRunAgainIsFoundAndInterruptFinishesTheFile) {
  RunningProgram client = [&] {
    RunningProgram server = serve();
    EXPECT_TRUE(server.wait_for_words("serving")) << server.words();
    RunningProgram recording_client = record({});
    EXPECT_TRUE(wait_for_frames(20));
    return recording_client;
  }();
  EXPECT_TRUE(client.wait_for_words("is lost; searching for it")) << client.words();
  RunningProgram server = serve();
  EXPECT_TRUE(client.wait_for_words("the camera is back")) << client.words();
  EXPECT_TRUE(wait_for_frames(25));
  client.send(SIGINT);
  EXPECT_EQ(client.wait(), 0) << client.words();
  const RecordingReader reader(recording());
  EXPECT_TRUE(reader.finished());
  EXPECT_GE(reader.count(), 25U);
}

/// Flags of the wire and of the client, and whether each frame then shows the next pattern.
struct Wired {
  std::vector<std::string> served, client;
  bool in_step;
};

class CameraProgramWiredCamera : public CameraProgram, public testing::WithParamInterface<Wired> {};

TEST_P(CameraProgramWiredCamera, ShowsEachPatternInItsFrameIfTheClientUsesTheWire) {
  const auto& [served, client, in_step] = GetParam();
  RunningProgram server = serve(with(served, {"--rate", "100"}));
  ASSERT_TRUE(server.wait_for_words("serving")) << server.words();
  ASSERT_EQ(record(with(client, {"--frames", "40"})).wait(), 0);
  const RecordingReader reader(recording());
  std::vector<Frame> frames(reader.count());
  for (std::uint64_t i = 0; i < frames.size(); ++i) ASSERT_TRUE(reader.read(i, frames[i]));
  ASSERT_EQ(frames.size(), 40U);
  std::size_t same = 0;
  for (std::size_t i = 12; i < 40; ++i) {
    const bool whole_round = frames[i].stamp.sequence == frames[i - 12].stamp.sequence + 12;
    if (in_step && whole_round) EXPECT_TRUE(same_pixels(frames[i], frames[i - 12])) << i;
    same += same_pixels(frames[i], frames[i - 1]) ? 1 : 0;
  }
  EXPECT_EQ(same, in_step ? 0U : 28U);
}

INSTANTIATE_TEST_SUITE_P(
    Wires, CameraProgramWiredCamera,
    testing::Values(Wired{{"--wired", "trigger"}, {"--trigger", "Line1"}, true},
                    Wired{{"--wired", "strobe"}, {"--strobe", "Line1"}, true},
                    Wired{{"--wired", "strobe"},
                          {"--strobe", "Line1", "--strobe-delay", "0.2", "--strobe-inverted"},
                          true},
                    Wired{{"--wired", "strobe"},
                          {"--feature", "LineSelector=Line1", "--feature", "LineMode=Output",
                           "--feature", "LineSource=ExposureActive"},
                          true},
                    Wired{{"--wired", "strobe"}, {}, false},
                    Wired{{"--wired", "strobe"}, {"--strobe", "Line0"}, false}));

class CameraProgramWiredRehearsal : public CameraProgram,
                                    public testing::WithParamInterface<std::string> {};

TEST_P(CameraProgramWiredRehearsal, OfTheLivePageIsInStep) {
  const std::vector<std::string> sequence{"--strategy", "dual-frequency", "--steps", "3", "--high",
                                          "16",         "--low",          "1"};
  const std::string scanner = folder_.path() / "scanner.yaml";
  RunningProgram server(with({"camera", "serve", "--camera", "160x120", "--cycles", "4", "--wired",
                              GetParam(), "--rate", "60", "--write-scanner", scanner},
                             sequence));
  ASSERT_TRUE(server.wait_for_words("serving")) << server.words();
  RunningProgram client(with({"live", "--source", "aravis:127.0.0.1", "--" + GetParam(), "Line1",
                              "--exposure", "5", "--indexing", "counted", "--scanner", scanner,
                              "--frames", "90", "--rate", "60", "--headless", "--json"},
                             sequence));
  ASSERT_EQ(client.wait(), 0) << client.words();
  const auto told = nlohmann::json::parse(client.out());
  EXPECT_EQ(told["resynchronisations"], 0);
  EXPECT_EQ(told["findings"], nlohmann::json::array());
  const auto lost = told["frames"]["lost"].get<int>() + told["frames"]["overwritten"].get<int>();
  EXPECT_GE(told["clouds"].get<int>(), 90 - 5 - 6 * lost);
  if (GetParam() == "strobe") {
    EXPECT_NE(client.err().find("LineSource = ExposureActive"), std::string::npos) << client.err();
  }
}

INSTANTIATE_TEST_SUITE_P(Both, CameraProgramWiredRehearsal, testing::Values("trigger", "strobe"));

TEST_F(CameraProgram, ANodeThatIsMissingRefusesOrReadsBackDifferentIsOneLine) {
  RunningProgram server = serve();
  ASSERT_TRUE(server.wait_for_words("serving")) << server.words();
  const auto expect_refused = [&](const std::vector<std::string>& flags, const std::string& why) {
    RunningProgram client = record(with(flags, {"--frames", "1"}));
    EXPECT_EQ(client.wait(), 2);
    EXPECT_NE(client.err().find(why), std::string::npos) << client.err();
    EXPECT_EQ(std::ranges::count(client.err(), '\n'), 1) << client.err();
  };
  expect_refused({"--feature", "ExposureAuto=Off"}, "has no node ExposureAuto");
  expect_refused({"--feature", "LineMode=Sideways"}, "refused LineMode = Sideways");
  expect_refused({"--strobe", "Line7"}, "refused LineSelector = Line7");
  expect_refused({"--feature", "LineInverter=yes"}, "refused LineInverter = yes");
  expect_refused({"--feature", "TimerDelay=2.7"}, "TimerDelay was set to 2.7 but reads back as 2");
}

TEST_F(CameraProgram, ListsTheServedCameraAsItIsOpened) {
  RunningProgram server = serve();
  ASSERT_TRUE(server.wait_for_words("serving pmp of 160x120 at 127.0.0.1 ")) << server.words();
  RunningProgram list({"camera", "list", "--json"});
  EXPECT_EQ(list.wait(), 0) << list.words();
  EXPECT_NE(list.words().find("aravis:Aravis-Fake-PROGRAM"), std::string::npos) << list.words();
}

TEST_F(CameraProgram, RefusesBadFlags) {
  const auto expect_refused = [&](const std::vector<std::string>& arguments, int code,
                                  const std::string& named) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, code) << run.err;
    EXPECT_NE(run.err.find(named), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(recording()));
  };
  const auto with_source = [&](const std::vector<std::string>& more) {
    return with({"record", "-o", recording()}, with(small_scan, more));
  };
  expect_refused(with_source({"--source", "tape:1"}), 2, "tape");
  expect_refused(with_source({"--source", "v4l2:x"}), 2, "v4l2:x");
  expect_refused(with_source({"--source", "v4l2:63"}), 1, "/dev/video63");
  expect_refused(with_source({"--source", "v4l2:0", "--trigger", "Line1"}), 2, "Line1");
  expect_refused(with_source({"--source", "v4l2:0", "--strobe", "Line1"}), 2, "Line1");
  expect_refused(with_source({"--source", "v4l2:0", "--feature", "A=b"}), 2, "--feature");
  expect_refused(with_source({"--source", "aravis:", "--feature", "Gamma"}), 2, "NAME=VALUE");
  expect_refused({"camera", "serve", "--wired", "round"}, 2, "round");
  expect_refused(with_source({"--source", "virtual", "--frames", "0"}), 2, "--frames 0");
  expect_refused(with_source({"--source", "aravis:", "--region", "640x480+1"}), 2, "640x480+1");
  expect_refused(with_source({"--source", "aravis:", "--pixel-format", "RGB8"}), 2, "RGB8");
  expect_refused(with_source({"--source", "aravis:", "--pixel-format", "RGB9"}), 2, "RGB9");
  // The patterns are grey, but three channels per picture would match three frames.
  expect_refused({"record", "-o", recording(), "--source", "virtual", "--strategy", "pmp",
                  "--steps", "3", "--pixel-format", "RGB8"},
                 2, "RGB8");
  expect_refused({"capture", "-o", recording(), "--source", "aravis:", "--monitor", "1",
                  "--strategy", "pmp", "--steps", "3", "--pixel-format", "RGB8"},
                 2, "RGB8");
  expect_refused({"record", "-o", recording(), "--source", "aravis:x"}, 2, "--strategy");
  expect_refused({"camera", "serve", "--packet-loss", "2"}, 2, "--packet-loss");
  expect_refused({"camera", "serve", "--cycles", "100000"}, 2, "--cycles 100000");
  expect_refused({"camera", "serve", "--camera-bits", "12"}, 2, "--camera-bits 12");
  expect_refused({"camera", "serve", "--projector", "64x48"}, 2, "--projector 64x48");
  expect_refused(with_source({"--source", "v4l2:0", "--gain", "1e12"}), 2, "--gain");
  expect_refused({"camera", "serve", "--camera", "32x24", "--address", "nowhere"}, 2, "nowhere");
}

}  // namespace slipstream::camera_program_test
