// `slipstream camera serve` and `slipstream record` as they are run, one against the other.
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "slipstream/camera/virtual_gige_camera.h"
#include "slipstream/error/error.h"
#include "slipstream/io/recording.h"
#include "tests/io/recorded_frames.h"
#include "tests/io/temporary_folder.h"

namespace slipstream {
namespace {
namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// The program, running; its words go to a file.
class RunningProgram {
 public:
  RunningProgram(const std::vector<std::string>& arguments, fs::path words)
      : words_(std::move(words)) {
    std::vector<const char*> argv{SLIPSTREAM_PROGRAM};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    argv.push_back(nullptr);
    const int to = ::open(words_.c_str(), O_RDWR | O_CREAT | O_TRUNC, 0666);
    process_ = ::fork();
    if (process_ == 0) {
      ::dup2(to, 1);
      ::dup2(to, 2);
      ::execv(argv[0], const_cast<char* const*>(argv.data()));
      ::_exit(127);
    }
    ::close(to);
  }
  RunningProgram(RunningProgram&& other) noexcept
      : words_(std::move(other.words_)), process_(std::exchange(other.process_, -1)) {}
  RunningProgram& operator=(RunningProgram&&) = delete;
  ~RunningProgram() {
    if (process_ > 0) {
      ::kill(process_, SIGKILL);
      (void)wait();
    }
  }

  void interrupt() const { ::kill(process_, SIGINT); }
  /// The exit code.
  int wait() {
    int status = 0;
    ::waitpid(std::exchange(process_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  [[nodiscard]] std::string words() const {
    std::ifstream stream(words_);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  [[nodiscard]] bool wait_for_words(const std::string& wanted) const {
    for (int tries = 0; tries < 3000 && words().find(wanted) == std::string::npos; ++tries) {
      std::this_thread::sleep_for(10ms);
    }
    return words().find(wanted) != std::string::npos;
  }

 private:
  fs::path words_;
  pid_t process_ = -1;
};

bool port_is_free() {
  try {
    const VirtualGigeCamera camera({some_frame(0)}, "127.0.0.1", "PROBE");
    return true;
  } catch (const WorldError&) {
    return false;
  }
}

const std::vector<std::string> small_scan{"--strategy", "pmp", "--steps", "4"};

std::vector<std::string> with(std::vector<std::string> arguments,
                              const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

class CameraProgram : public testing::Test {
 protected:
  void SetUp() override {
    if (!port_is_free()) GTEST_SKIP() << "no camera can be served at 127.0.0.1";
  }

  [[nodiscard]] RunningProgram serve() const {
    return {with({"camera", "serve", "--camera", "160x120", "--scene", "sphere", "--cycles", "3",
                  "--serial", "PROGRAM"},
                 small_scan),
            folder_.path() / "serve.txt"};
  }
  [[nodiscard]] RunningProgram record(const std::vector<std::string>& more) const {
    return {with({"record", "--source", "aravis:127.0.0.1", "-o", recording(), "--rate", "100"},
                 with(small_scan, more)),
            folder_.path() / "record.txt"};
  }
  [[nodiscard]] std::string recording() const { return folder_.path() / "frames.slip"; }

  TemporaryFolder folder_;
};

TEST_F(CameraProgram, RecordsWhatTheOtherServes) {
  RunningProgram server = serve();
  ASSERT_TRUE(server.wait_for_words("serving pmp of 160x120")) << server.words();
  RunningProgram client = record({"--frames", "50", "--json"});
  EXPECT_EQ(client.wait(), 0) << client.words();
  EXPECT_NE(client.words().find("\"frames\": 50"), std::string::npos) << client.words();
  server.interrupt();
  EXPECT_EQ(server.wait(), 0) << server.words();

  const RecordingReader reader(recording());
  EXPECT_TRUE(reader.finished());
  ASSERT_EQ(reader.count(), 50U);
  EXPECT_EQ(reader.header().frame_rate, 100);
  // Three scans over and over: frames twelve apart are the same, neighbours are not.
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
    for (int tries = 0; tries < 1000; ++tries) {
      std::error_code none;
      const auto size = fs::file_size(recording(), none);
      if (!none && size > 20 * 160 * 120) break;
      std::this_thread::sleep_for(10ms);
    }
    return recording_client;
  }();
  EXPECT_TRUE(client.wait_for_words("is gone; looking for it")) << client.words();
  RunningProgram server = serve();
  EXPECT_TRUE(client.wait_for_words("the camera is back")) << client.words();
  std::this_thread::sleep_for(500ms);
  client.interrupt();
  EXPECT_EQ(client.wait(), 0) << client.words();
  const RecordingReader reader(recording());
  EXPECT_TRUE(reader.finished());
  EXPECT_GT(reader.count(), 20U);
}

TEST_F(CameraProgram, ListsTheServedCameraAsItIsOpened) {
  RunningProgram server = serve();
  ASSERT_TRUE(server.wait_for_words("serving")) << server.words();
  RunningProgram list({"camera", "list", "--json"}, folder_.path() / "list.txt");
  EXPECT_EQ(list.wait(), 0) << list.words();
  EXPECT_NE(list.words().find("aravis:Aravis-Fake-PROGRAM"), std::string::npos) << list.words();
}

TEST_F(CameraProgram, RefusesBadFlags) {
  const auto expect_refused = [&](const std::vector<std::string>& arguments, int code,
                                  const std::string& named) {
    RunningProgram run(arguments, folder_.path() / "refused.txt");
    EXPECT_EQ(run.wait(), code) << run.words();
    EXPECT_NE(run.words().find(named), std::string::npos) << run.words();
    EXPECT_FALSE(fs::exists(recording()));
  };
  const auto with_source = [&](const std::vector<std::string>& more) {
    return with({"record", "-o", recording()}, with(small_scan, more));
  };
  expect_refused(with_source({"--source", "tape:1"}), 2, "tape");
  expect_refused(with_source({"--source", "v4l2:x"}), 2, "v4l2:x");
  expect_refused(with_source({"--source", "v4l2:63"}), 1, "/dev/video63");
  expect_refused(with_source({"--source", "v4l2:0", "--trigger", "Line1"}), 2, "Line1");
  expect_refused(with_source({"--source", "virtual", "--frames", "0"}), 2, "--frames 0");
  expect_refused(with_source({"--source", "aravis:", "--region", "640x480+1"}), 2, "640x480+1");
  expect_refused(with_source({"--source", "aravis:", "--pixel-format", "RGB8"}), 2, "RGB8");
  expect_refused({"record", "-o", recording(), "--source", "aravis:x"}, 2, "--strategy");
  expect_refused({"camera", "serve", "--packet-loss", "2"}, 2, "--packet-loss");
  expect_refused({"camera", "serve", "--camera", "32x24", "--address", "nowhere"}, 2, "nowhere");
}

}  // namespace
}  // namespace slipstream
