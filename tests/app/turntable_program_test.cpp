// Takes views of an object on a turntable with `capture` and `simulate`.
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "slipstream/scan_files.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::turntable_program_test {
namespace fs = std::filesystem;

class TurntableProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_.path() / name).string();
  }

  /// Runs `command` for two views of two virtual boxes.
  [[nodiscard]] ProgramRun views(const std::string& command, std::vector<std::string> more) const {
    std::vector<std::string> arguments{command,   "--turntable", "2",       "--camera", "160x120",
                                       "--scene", "boxes",       "--world", "ideal"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }

  static void expect_refused(const ProgramRun& run, const std::string& part) {
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
  }

  TemporaryFolder folder_;
};

TEST_F(TurntableProgram, TakesAScanOfEachView) {
  const ProgramRun simulated = views("simulate", {path("views"), "--turn-step", "90", "--json"});
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const auto told = nlohmann::json::parse(simulated.out);
  EXPECT_EQ(told["views"].size(), 2U);
  EXPECT_EQ(told["step_degrees"], 90);
  EXPECT_LT(told["axis_direction"][1].get<double>(), -0.9) << "upwards";

  // The same by the virtual camera, whose command is told angle and number.
  const ProgramRun captured = views(
      "capture", {"--source", "virtual", "-o", path("taken"), "--turn-step", "90", "--turn-command",
                  "echo turning; echo {step} {view} > " + path("told"), "--auto", "--json"});
  ASSERT_EQ(captured.exit_code, 0) << captured.err;
  EXPECT_NE(captured.err.find("turning"), std::string::npos) << captured.err;
  const auto document = nlohmann::json::parse(captured.out);
  EXPECT_EQ(document["views"].size(), 2U);
  EXPECT_TRUE(document.contains("automatic"));
  EXPECT_EQ(read_text(path("told")), "90 2\n");

  for (const char* const folder : {"views", "taken"}) {
    const Scan first = load_scan(fs::path(path(folder)) / "view01");
    const Scan second = load_scan(fs::path(path(folder)) / "view02");
    EXPECT_TRUE(first.scanner.has_value());
    EXPECT_EQ(first.frames.count(), second.frames.count());
  }
  EXPECT_NE(read_file(path("views/view01/frame_00.png")),
            read_file(path("views/view02/frame_00.png")));
}

TEST_F(TurntableProgram, RefusesBadTurns) {
  expect_refused(views("simulate", {path("views"), "--turn-step", "200"}), "-180 to 180");
  expect_refused(
      run_program({"capture", "--source", "virtual", "-o", path("views"), "--turntable", "1"}),
      "2 to 1000");
  expect_refused(
      run_program({"capture", "--source", "virtual", "-o", path("views"), "--turn-step", "3"}),
      "--turntable");

  // A replay shows no object that turns, and a recording holds one view.
  expect_refused(run_program({"capture", "--source", "replay:" + path("views"), "-o", path("taken"),
                              "--turntable", "3"}),
                 "no object that turns");
  expect_refused(views("capture", {"--source", "virtual", "-o", path("taken.slip")}),
                 "--turntable needs a folder");

  // A command that fails, which a rig file may not name at all.
  const ProgramRun failed =
      views("capture", {"--source", "virtual", "-o", path("one"), "--turn-command", "false"});
  EXPECT_EQ(failed.exit_code, 1) << failed.err;
  EXPECT_NE(failed.err.find("'false' failed with exit code 1"), std::string::npos) << failed.err;
  const ProgramRun ended = views(
      "capture", {"--source", "virtual", "-o", path("three"), "--turn-command", "kill -9 $$"});
  EXPECT_NE(ended.err.find("ended by signal 9"), std::string::npos) << ended.err;

  std::ofstream(path("rig.yaml")) << "turn-command: touch " << path("touched") << "\n";
  expect_refused(
      views("capture", {"--source", "virtual", "-o", path("two"), "--rig", path("rig.yaml")}),
      "a rig file may not run commands");
  EXPECT_FALSE(fs::exists(path("touched")));
}

}  // namespace slipstream::turntable_program_test
