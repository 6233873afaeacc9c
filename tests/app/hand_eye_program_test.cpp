// Runs `slipstream calibrate hand-eye`, `touch` and `virtual-robot`.
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "io/pose_file.h"
#include "slipstream/cloud_file.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::hand_eye_program_test {
namespace fs = std::filesystem;

class HandEyeProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  void rehearse(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"calibrate", "virtual-robot", path("r")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = run_program(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  [[nodiscard]] ProgramRun calibrate(const std::string& eye,
                                     const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{
        "calibrate", "hand-eye", path("r/robot.csv"), path("r/boards.csv"), "--eye",
        eye,         "-o",       path("camera.yaml")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }

  [[nodiscard]] double off() const {
    const FramePose found = read_pose(path("camera.yaml"));
    const FramePose truth = read_pose(path("r/truth.yaml"));
    EXPECT_EQ(found.to, truth.to);
    return (found.transform.translation() - truth.transform.translation()).norm();
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(HandEyeProgram, GivesAPoseFileAReportAndADocument) {
  rehearse({"--eye", "in-hand"});
  const ProgramRun run = calibrate("in-hand", {"--report", path("report"), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LT(off(), 0.5);

  const nlohmann::json document = nlohmann::json::parse(run.out);
  EXPECT_EQ(document["robot_convention"], "intrinsic zyx in degrees, mm, tool to base");
  EXPECT_EQ(document["poses"].size(), 15U);
  EXPECT_EQ(document["to"], "tool");
  EXPECT_NE(contents(path("report/report.html")).find("Hand-eye calibration"), std::string::npos);
  EXPECT_NE(contents(path("report/residuals.yaml")).find("left_out_mm"), std::string::npos);
}

TEST_F(HandEyeProgram, TheTouchTestFindsAnInjectedError) {
  rehearse({"--eye", "to-hand", "--robot-convention", "ur, m, base to tool"});
  ASSERT_EQ(calibrate("to-hand").exit_code, 0);
  EXPECT_LT(off(), 0.5);

  const auto touch = [&](const std::string& pose) {
    return run_program({"calibrate", "touch", pose, "--points", path("r/points.xyz"), "--touched",
                        path("r/touched.csv"), "--tip", "0,0,150", "--robot-convention",
                        "ur, m, base to tool", "--tolerance", "0.3"});
  };
  EXPECT_EQ(touch(path("r/truth.yaml")).exit_code, 0);

  FramePose wrong = read_pose(path("r/truth.yaml"));
  wrong.transform.translation().y() += 0.5;
  write_pose(path("wrong.yaml"), wrong);
  const ProgramRun run = touch(path("wrong.yaml"));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.out.find("+0.500 mm in y"), std::string::npos) << run.out << run.err;
}

TEST_F(HandEyeProgram, TheTouchTestOfOnePointHasNoStandardError) {
  rehearse({"--eye", "to-hand", "--robot-convention", "ur, m, base to tool"});
  const auto cut = [&](const std::string& name, const std::string& to) {
    const std::string all = contents(path(name));
    const std::size_t first = all.find('\n');
    write_file(path(to), all.substr(0, all.find('\n', first + 1) + 1));
  };
  cut("r/points.xyz", "point.xyz");
  cut("r/touched.csv", "touched.csv");

  const auto touch = [&](const std::string& points) {
    return run_program({"calibrate", "touch", path("r/truth.yaml"), "--points", points, "--touched",
                        path("touched.csv"), "--tip", "0,0,150", "--robot-convention",
                        "ur, m, base to tool"});
  };
  const ProgramRun run = touch(path("point.xyz"));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("mean: "), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("nan"), std::string::npos) << run.out;

  // Points in another frame are not the camera's.
  StoredCloud stored = read_cloud(path("point.xyz"));
  move_to_frame(stored.cloud, {.from = "camera", .to = "robot_base"});
  write_cloud(path("moved.ply"), stored.cloud);
  const ProgramRun refused = touch(path("moved.ply"));
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("in the frame robot_base"), std::string::npos) << refused.err;
}

TEST_F(HandEyeProgram, RefusesInOneLine) {
  rehearse({});
  const auto expect_refused = [&](const ProgramRun& run, const std::string& part) {
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(path("camera.yaml")));
  };

  expect_refused(calibrate("in-eye"), "in-eye");
  expect_refused(calibrate("to-hand", {"--robot-convention", "tool to base"}), "behind the camera");
  expect_refused(calibrate("in-hand", {"--robot-convention", "inches"}), "inches");
  write_file(path("r/robot.csv"), "x,y,z\n1,2,3\n");
  expect_refused(calibrate("in-hand"), "robot.csv");
}

}  // namespace slipstream::hand_eye_program_test
