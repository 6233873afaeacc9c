// simulate --guard, and what reconstruct and check make of it.
#include <algorithm>
#include <filesystem>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "slipstream/scan_files.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::guard_program_test {
namespace fs = std::filesystem;

bool contains(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

class GuardProgram : public testing::Test {
 protected:
  void SetUp() override { copy_simulated_scan({"--camera", "160x120", "--guard"}, path("scan")); }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  /// Turns the camera in the scan's scanner file by an angle, rad.
  void turn_camera(double angle) const {
    Scanner scanner = read_scanner(path("scan/scanner.yaml"));
    scanner.rotation =
        (Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()) * scanner.rotation).eval();
    write_scanner(path("scan/scanner.yaml"), scanner);
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(GuardProgram, ConfirmsARigThatStands) {
  const ProgramRun checked = run_program({"check", path("scan")});
  EXPECT_EQ(checked.exit_code, 0);
  EXPECT_TRUE(contains(checked.out, "OK: no problems found")) << checked.out;
  EXPECT_TRUE(contains(checked.out, "guard: distance from epipolar lines")) << checked.out;

  const ProgramRun made = run_program({"reconstruct", path("scan"), "--json"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const nlohmann::json scan = nlohmann::json::parse(made.out)["scans"][0];
  EXPECT_LT(scan["guard"]["common_px"], 0.3);
  EXPECT_TRUE(scan["findings"].empty()) << scan["findings"];
  EXPECT_FALSE(contains(made.err, "no guard")) << made.err;
}

TEST_F(GuardProgram, RefusesAScanOfARigThatMoved) {
  turn_camera(0.02);
  for (const char* const command : {"check", "reconstruct"}) {
    const ProgramRun run = run_program({command, path("scan")});
    EXPECT_EQ(run.exit_code, 2) << command;
    EXPECT_TRUE(contains(run.out + run.err, "the camera turned by 1.")) << run.err;
  }
  EXPECT_EQ(run_program({"reconstruct", path("scan"), "--anyway"}).exit_code, 0);
}

TEST_F(GuardProgram, WarnsOfARigThatMovedALittle) {
  turn_camera(0.0008);
  const ProgramRun run = run_program({"reconstruct", path("scan")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains(run.err, "do not stand as the scanner file says")) << run.err;
}

TEST_F(GuardProgram, IsAScanOfItsOwn) {
  EXPECT_EQ(load_scan(path("scan/guard")).sequence.axis, Axis::y);
  EXPECT_EQ(run_program({"check", path("scan/guard")}).exit_code, 0);
}

TEST_F(GuardProgram, SaysOnceThatNothingShowsAMovedRig) {
  std::string description = contents(path("scan/scan.yaml"));
  const std::size_t key = description.find("guard: guard\n");
  ASSERT_NE(key, std::string::npos) << description;
  write_file(path("scan/scan.yaml"), description.erase(key));

  turn_camera(0.02);
  const ProgramRun run = run_program({"reconstruct", path("scan"), path("scan")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::size_t first = run.out.find("no guard");
  ASSERT_NE(first, std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("no guard", first + 1), std::string::npos) << run.out;
}

TEST_F(GuardProgram, LeavesAGuardOutAlongTheSameAxis) {
  std::string description = contents(path("scan/guard/scan.yaml"));
  const std::size_t axis = description.find("axis: y");
  ASSERT_NE(axis, std::string::npos) << description;
  write_file(path("scan/guard/scan.yaml"), description.replace(axis, 7, "axis: x"));
  const ProgramRun run = run_program({"reconstruct", path("scan")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains(run.err, "must vary along y alone")) << run.err;
}

TEST_F(GuardProgram, PartOfTheScansChecksum) {
  const std::uint32_t before = checksum_of(scan_files_in(path("scan")));
  fs::copy_file(path("scan/guard/frame_01.png"), path("scan/guard/frame_00.png"),
                fs::copy_options::overwrite_existing);
  EXPECT_NE(checksum_of(scan_files_in(path("scan"))), before);
}

TEST_F(GuardProgram, RefusesGuardsThatCannotBe) {
  for (const std::string output : {"one.slip", "both"}) {
    const ProgramRun run = run_program({"simulate", path(output), "--guard", "--camera", "64x48",
                                        "--axis", output == "both" ? "both" : "x"});
    EXPECT_EQ(run.exit_code, 2) << output;
    EXPECT_TRUE(contains(run.err, "--guard")) << run.err;
    EXPECT_FALSE(fs::exists(path(output)));
  }
}

}  // namespace slipstream::guard_program_test
