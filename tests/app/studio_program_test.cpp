// Presses the keys of the studio's buttons under Xvfb: from the virtual scanner to a cloud.
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <thread>

#include <gtest/gtest.h>

#include "slipstream/cloud_file.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"
#include "tests/view/desktop.h"

namespace slipstream::studio_program_test {
namespace fs = std::filesystem;

/// Whether it comes within ten minutes, which a busy machine may take to render boards.
bool comes(const std::function<bool()>& wanted) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(10);
  while (!wanted()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

class StudioProgram : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(std::system("xdotool version > /dev/null"), 0) << "xdotool is not installed";
  }
  /// Starts it; false without a desktop.
  bool open(const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"studio", "--save-to", folder_.path().string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    studio_.emplace(arguments);
    return comes([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      return std::system(
                 "timeout 5 xdotool search --name 'slipstream studio' windowfocus "
                 "> /dev/null 2>&1") == 0;
    });
  }
  static void press(const std::string& key) {
    ASSERT_EQ(std::system(("xdotool key " + key).c_str()), 0);
  }
  /// The first folder whose name begins so and that has the file.
  [[nodiscard]] std::string folder_with(const std::string& begin, const std::string& file) const {
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      if (entry.path().filename().string().starts_with(begin) && fs::exists(entry.path() / file)) {
        return entry.path().string();
      }
    }
    return {};
  }
  /// Presses Capture until there is a scan, as the first pictures take a moment.
  std::string captured() const {
    std::string scan;
    EXPECT_TRUE(comes([&] {
      press("s");
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
      scan = folder_with("scan", "preview.png");
      return !scan.empty();
    }));
    return scan;
  }
  void expect_ends() {
    EXPECT_TRUE(comes([] {  // until there is no window
      press("Escape");
      press("Return");
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      return std::system("timeout 5 xdotool search --name 'slipstream' > /dev/null 2>&1") != 0;
    }));
    EXPECT_EQ(studio_->wait(), 0) << studio_->err();
  }

  Desktop desktop_;
  TemporaryFolder folder_;
  std::optional<RunningProgram> studio_;
};

TEST_F(StudioProgram, CapturesACloudOfTheVirtualScanner) {
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_TRUE(open({"--camera", "320x240"})) << studio_->err();
  press("l");
  const std::string scan = captured();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  RecordProperty("seconds", std::to_string(took.count()));
  ASSERT_FALSE(scan.empty());
  EXPECT_TRUE(studio_->wait_for_words("saved: ")) << studio_->words();
  EXPECT_GT(point_count(read_cloud(scan + "/cloud.ply").cloud), 320U * 240 / 2);
  const ProgramRun checked = run_program({"check", scan});
  EXPECT_EQ(checked.exit_code, 0) << checked.out << checked.err;
  expect_ends();
}

TEST_F(StudioProgram, CalibratesAndCapturesWithTheNewScanner) {
  ASSERT_TRUE(open({})) << studio_->err();
  press("c");
  std::string poses;
  ASSERT_TRUE(comes([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    poses = folder_with("poses", "report/report.html");
    return !poses.empty();
  })) << studio_->words();
  ASSERT_TRUE(studio_->wait_for_words("scanner file: ")) << studio_->words();
  press("l");
  const std::string scan = captured();
  ASSERT_FALSE(scan.empty());
  EXPECT_EQ(read_scanner(scan + "/scanner.yaml").translation,
            read_scanner(poses + "/scanner.yaml").translation);
  expect_ends();
}

TEST_F(StudioProgram, IsWhatViewShowsWithoutAPath) {
  studio_.emplace(std::vector<std::string>{"view"});
  ASSERT_TRUE(comes([&] {
    return std::system(
               "timeout 5 xdotool search --name 'slipstream studio' windowfocus "
               "> /dev/null 2>&1") == 0;
  }));
  studio_->send(SIGINT);
  EXPECT_EQ(studio_->wait(), 0) << studio_->err();
}

}  // namespace slipstream::studio_program_test
