// Runs `slipstream calibrate hand-eye`, `touch`, `projection` and `virtual-robot`.
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "geometry/rotation.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/pose_file.h"
#include "slipstream/cloud_file.h"
#include "slipstream/scanner_file.h"
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
  EXPECT_EQ(nlohmann::json::parse(contents(path("report/residuals.yaml"))), document["poses"]);
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

TEST_F(HandEyeProgram, TheProjectionTestFindsAnInjectedError) {
  const auto run = [](const std::vector<std::string>& arguments) {
    const ProgramRun done = run_program(arguments);
    ASSERT_EQ(done.exit_code, 0) << done.err;
  };
  const std::string scanner = path("boards/scanner.yaml");
  run({"simulate", path("boards"), "--boards", "1", "--corners", "13x9", "--spacing", "15",
       "--camera", "640x480"});
  run({"frame", "board", path("boards/board01"), "--scanner", scanner, "--corners", "13x9",
       "--spacing", "15", "-o", path("board.yaml")});

  // A camera beside a robot that has touched the four outer corners.
  const FramePose truth{"camera", "base",
                        pose_from(rotation_of_euler({3.1, -0.2, 0.5}, {}), {900, -250, 1400})};
  write_pose(path("truth.yaml"), truth);
  const Eigen::Isometry3d board =
      truth.transform * read_pose(path("board.yaml")).transform.inverse();
  std::string touched = "x,y,z,a,b,c\n";
  for (const auto& [x, y] :
       std::vector<std::pair<double, double>>{{0, 0}, {180, 0}, {180, 120}, {0, 120}}) {
    const Eigen::Vector3d tool = board * Eigen::Vector3d(x, y, 0) - Eigen::Vector3d(0, 0, 150);
    touched += fmt::format("{:.4f},{:.4f},{:.4f},0,0,0\n", tool.x(), tool.y(), tool.z());
  }
  write_file(path("touched.csv"), touched);

  const auto project = [&](const std::string& pose) {
    return run_program({"calibrate",
                        "projection",
                        pose,
                        "--touched",
                        path("touched.csv"),
                        "--tip",
                        "0,0,150",
                        "--robot-convention",
                        "kuka, mm, tool to base",
                        "--boards",
                        path("boards"),
                        "--scanner",
                        scanner,
                        "--corners",
                        "13x9",
                        "--spacing",
                        "15",
                        "--tolerance",
                        "0.3",
                        "--rings",
                        path("rings.png"),
                        "--json"});
  };
  const ProgramRun good = project(path("truth.yaml"));
  EXPECT_EQ(good.exit_code, 0) << good.err << good.out;
  EXPECT_EQ(read_levels(path("rings.png")).size(), read_scanner(scanner).projector.size);

  // Half a millimetre along either axis of the board, either way.
  for (const int axis : {0, 1}) {
    for (const double error : {-0.5, 0.5}) {
      const Eigen::Vector3d off = error * board.linear().col(axis);
      FramePose wrong = truth;
      wrong.transform.translation() += off;
      write_pose(path("wrong.yaml"), wrong);
      const ProgramRun bad = project(path("wrong.yaml"));
      EXPECT_EQ(bad.exit_code, 2);
      const nlohmann::json mean = nlohmann::json::parse(bad.out)["mean_mm"];
      const Eigen::Vector3d found(mean[0].get<double>(), mean[1].get<double>(),
                                  mean[2].get<double>());
      EXPECT_LT((found - off).norm(), 0.1) << found.transpose() << ", not " << off.transpose();
    }
  }
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
