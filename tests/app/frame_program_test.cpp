// Runs `slipstream frame`, and --to-frame of the commands that make clouds.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "geometry/rotation.h"
#include "io/file.h"
#include "io/pose_file.h"
#include "slipstream/cloud_file.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::frame_program_test {

const FramePose base_pose{"camera", "robot_base",
                          pose_from(rotation_of_euler({3.1, -0.2, 0.5}, {}), {900, -250, 1400})};

class FrameProgram : public testing::Test {
 protected:
  void SetUp() override { write_pose(path("base.yaml"), base_pose); }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  void simulate(const std::string& name, const std::string& scene = "sphere") const {
    copy_simulated_scan({"--scene", scene, "--camera", "160x120"}, path(name));
  }

  static void expect_done(const std::vector<std::string>& arguments) {
    const ProgramRun run = run_program(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  static nlohmann::json document(std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.exit_code == 0 ? nlohmann::json::parse(run.out) : nlohmann::json();
  }

  static void expect_refused(const std::vector<std::string>& arguments, const std::string& part) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
    EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
  }

 private:
  TemporaryFolder folder_;
};

/// The same points, one for each pixel, moved by the pose.
void expect_moved(const Cloud& given, const Cloud& moved) {
  ASSERT_EQ(given.size(), moved.size());
  double largest = 0;
  for_each_pixel_in_order(given.size(), [&](int column, int row) {
    ASSERT_EQ(given.validity(column, row), moved.validity(column, row));
    if (given.validity(column, row) != Validity::valid) return;
    const Eigen::Vector3d expected = base_pose.transform * position_at(given, column, row);
    largest = std::max(largest, (position_at(moved, column, row) - expected).norm());
  });
  EXPECT_LT(largest, 2e-3);
}

TEST_F(FrameProgram, ReconstructsIntoTheFrameInEitherDirection) {
  simulate("scan");
  write_pose(path("inverse.yaml"), inverse(base_pose));
  expect_done({"reconstruct", path("scan"), "-o", path("camera.pcd")});
  for (const char* pose : {"base.yaml", "inverse.yaml"}) {
    expect_done({"reconstruct", path("scan"), "-o", path("moved.pcd"), "--to-frame", path(pose)});
    const StoredCloud moved = read_cloud(path("moved.pcd"));
    EXPECT_EQ(frame_name(moved.cloud), "robot_base");
    EXPECT_TRUE(moved.organised);
    expect_moved(read_cloud(path("camera.pcd")).cloud, moved.cloud);
  }
}

TEST_F(FrameProgram, LiveAndItsFilesAreInTheFrame) {
  const auto live = [&](const std::string& cloud, const std::string& mcap, bool moved) {
    std::vector<std::string> arguments{"live",       "--source",  "virtual",   "--world",
                                       "ideal",      "--camera",  "160x120",   "--rate",
                                       "0",          "--frames",  "9",         "--headless",
                                       "-o",         path(cloud), "--publish", "mcap:" + path(mcap),
                                       "--strategy", "pmp",       "--steps",   "3"};
    if (moved) arguments.insert(arguments.end(), {"--to-frame", path("base.yaml")});
    expect_done(arguments);
  };
  live("camera.pcd", "camera.mcap", false);
  live("moved.pcd", "moved.mcap", true);
  expect_moved(read_cloud(path("camera.pcd")).cloud, read_cloud(path("moved.pcd")).cloud);

  // The transform in the file says where the camera is.
  expect_done({"convert", path("moved.mcap"), "-o", path("of-mcap.pcd")});
  const StoredCloud converted = read_cloud(path("of-mcap.pcd"));
  EXPECT_EQ(frame_name(converted.cloud), "robot_base");
  EXPECT_TRUE(converted.cloud.frame->transform.isApprox(base_pose.transform, 1e-6));
}

TEST_F(FrameProgram, McapOfSeveralCloudsHasThePlaceOfTheCameraOfEach) {
  simulate("scan");
  expect_done({"convert", path("scan"), "-o", path("camera.pcd")});
  FramePose other_pose = base_pose;
  other_pose.transform.translation().x() += 50;
  write_pose(path("other.yaml"), other_pose);

  for (const std::string pose : {"base", "other"}) {
    expect_done({"convert", path("camera.pcd"), "-o", path(pose + ".pcd"), "--to-frame",
                 path(pose + ".yaml")});
  }
  expect_done({"convert", path("base.pcd"), path("other.pcd"), "-o", path("both.mcap")});
  expect_done({"convert", path("both.mcap"), "-o", path("{window}.pcd")});

  const auto pose_of = [&](const std::string& file) {
    return read_cloud(path(file)).cloud.frame->transform;
  };
  EXPECT_TRUE(pose_of("000000.pcd").isApprox(base_pose.transform, 1e-6));
  EXPECT_TRUE(pose_of("000001.pcd").isApprox(other_pose.transform, 1e-6));
}

TEST_F(FrameProgram, ConvertTakesACloudOnToTheNextFrameAndBack) {
  simulate("scan");
  expect_done({"convert", path("scan"), "-o", path("camera.pcd")});
  expect_done(
      {"convert", path("camera.pcd"), "-o", path("base.pcd"), "--to-frame", path("base.yaml")});
  expect_moved(read_cloud(path("camera.pcd")).cloud, read_cloud(path("base.pcd")).cloud);

  write_pose(path("world.yaml"),
             {"robot_base", "world", pose_from(Eigen::Matrix3d::Identity(), {0, 0, 1000})});
  expect_done(
      {"convert", path("base.pcd"), "-o", path("world.pcd"), "--to-frame", path("world.yaml")});
  EXPECT_EQ(frame_name(read_cloud(path("world.pcd")).cloud), "world");
  expect_refused(
      {"convert", path("camera.pcd"), "-o", path("no.pcd"), "--to-frame", path("world.yaml")},
      "between the frames robot_base and world");
  EXPECT_FALSE(std::filesystem::exists(path("no.pcd")));
}

TEST_F(FrameProgram, RefusesPosesOfOtherFramesBeforeAnyWork) {
  simulate("scan");
  write_pose(path("other.yaml"), FramePose{"flange", "base"});
  expect_refused(
      {"reconstruct", path("scan"), "-o", path("a.ply"), "--to-frame", path("other.yaml")},
      "expected one from or to the frame camera");
  write_file(path("broken.yaml"), "from: camera\nto: base\nunit: cm\n");
  expect_refused({"reconstruct", path("scan"), "--to-frame", path("broken.yaml")},
                 "broken.yaml: no rotation");
  EXPECT_FALSE(std::filesystem::exists(path("a.ply")));
}

TEST_F(FrameProgram, BoxIsInTheFrame) {
  simulate("scan");
  expect_done({"reconstruct", path("scan"), "--raw", "-o", path("all.pcd"), "--to-frame",
               path("base.yaml")});
  const Cloud all = read_cloud(path("all.pcd")).cloud;

  // Half of the points by their x in the frame.
  std::vector<float> xs;
  for (const float x : all.x) {
    if (!std::isnan(x)) xs.push_back(x);
  }
  std::ranges::nth_element(xs, xs.begin() + std::ssize(xs) / 2);
  const double middle = xs[xs.size() / 2];
  const std::string box = fmt::format("{:.3f},-1e4,-1e4,1e5,1e4,1e4", middle);
  expect_done({"reconstruct", path("scan"), "--raw", "--box=" + box, "-o", path("half.pcd"),
               "--to-frame", path("base.yaml")});

  const Cloud half = read_cloud(path("half.pcd")).cloud;
  EXPECT_NEAR(static_cast<double>(point_count(half)), 0.5 * static_cast<double>(xs.size()), 2);
  for (const float x : half.x) EXPECT_FALSE(x < middle - 1e-2);
}

TEST_F(FrameProgram, MeasuresInTheFrame) {
  simulate("scan");
  expect_done(
      {"reconstruct", path("scan"), "-o", path("moved.pcd"), "--to-frame", path("base.yaml")});
  const std::vector<std::string> asked{"--point",     "80,60",   "--sphere",
                                       "40x40+60+40", "--plane", "9x9+76+56"};
  const auto measured = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "measure");
    arguments.insert(arguments.end(), asked.begin(), asked.end());
    return document(arguments);
  };
  const nlohmann::json camera = measured({path("scan")});
  const nlohmann::json scan = measured({path("scan"), "--to-frame", path("base.yaml")});
  const nlohmann::json cloud = measured({path("moved.pcd")});
  EXPECT_EQ(camera["frame"], "camera");
  EXPECT_EQ(scan["frame"], "robot_base");
  EXPECT_EQ(cloud["frame"], "robot_base");

  const auto vector = [](const nlohmann::json& list) {
    return Eigen::Vector3d(list[0].get<double>(), list[1].get<double>(), list[2].get<double>());
  };
  const Eigen::Vector3d point = base_pose.transform * vector(camera["points"][0]["position_mm"]);
  const Eigen::Vector3d normal =
      base_pose.transform.linear() * vector(camera["planes"][0]["normal"]);
  for (const nlohmann::json* const moved : {&scan, &cloud}) {
    EXPECT_LT((vector((*moved)["points"][0]["position_mm"]) - point).norm(), 2e-3);
    EXPECT_LT((vector((*moved)["planes"][0]["normal"]) - normal).norm(), 1e-3);
    EXPECT_NEAR((*moved)["spheres"][0]["radius_mm"].get<double>(),
                camera["spheres"][0]["radius_mm"].get<double>(), 1e-2);
  }
}

TEST_F(FrameProgram, ConvertsInvertsAndComposes) {
  write_pose(path("world.yaml"),
             {"world", "robot_base", pose_from(rotation_of_vector({0, 0, 1}), {1, 2, 3})});
  expect_done({"frame", "convert", path("base.yaml"), "--as", "euler intrinsic zyx", "--metres",
               "-o", path("euler.yaml")});
  EXPECT_NE(read_text(path("euler.yaml")).find("order: intrinsic zyx"), std::string::npos);
  EXPECT_TRUE(read_pose(path("euler.yaml")).transform.isApprox(base_pose.transform, 1e-12));

  expect_done({"frame", "invert", path("base.yaml"), "-o", path("inverse.yaml")});
  EXPECT_EQ(read_pose(path("inverse.yaml")).from, "robot_base");

  // Camera to base, then from the world's pose in the other direction.
  const nlohmann::json whole = document(
      {"frame", "compose", path("inverse.yaml"), path("world.yaml"), "-o", path("whole.yaml")});
  EXPECT_EQ(whole["from"], "camera");
  EXPECT_EQ(whole["to"], "world");
  const Eigen::Isometry3d expected =
      read_pose(path("world.yaml")).transform.inverse() * base_pose.transform;
  EXPECT_TRUE(read_pose(path("whole.yaml")).transform.isApprox(expected, 1e-9));

  write_pose(path("other.yaml"), FramePose{"tool", "part"});
  expect_refused({"frame", "compose", path("base.yaml"), path("other.yaml")}, "share none");
  expect_refused({"frame", "convert", path("base.yaml"), "--as", "euler zyx"}, "intrinsic zyx");
  EXPECT_EQ(run_program({"frame", "convert", path("base.yaml"), "-o", path("base.txt")}).out, "");
}

TEST_F(FrameProgram, FindsAFrameFromPointsAndSaysTheResiduals) {
  simulate("scan", "board");
  expect_done({"reconstruct", path("scan"), "-o", path("camera.pcd")});
  const Cloud cloud = read_cloud(path("camera.pcd")).cloud;

  // Pixels whose places in the base are known, once exactly and once with one mistyped.
  std::vector<std::string> picks{"frame", "points", path("scan"), "--name", "robot_base"};
  std::string pairs = "# camera, base\n";
  for (const auto& [column, row] :
       std::vector<std::pair<int, int>>{{60, 40}, {100, 40}, {60, 80}, {100, 80}, {80, 60}}) {
    const Eigen::Vector3d point = position_at(cloud, column, row);
    const Eigen::Vector3d place = base_pose.transform * point;
    ASSERT_TRUE(point.allFinite()) << column << ", " << row;
    picks.insert(picks.end(),
                 {"--pick", fmt::format("{},{}", column, row),
                  fmt::format("{:.6f},{:.6f},{:.6f}", place.x(), place.y(), place.z())});
    const double typed = column == 80 ? place.z() + 5 : place.z();
    pairs += fmt::format("{}, {}, {}, {}, {}, {}\n", point.x(), point.y(), point.z(), place.x(),
                         place.y(), typed);
  }
  const nlohmann::json found = document(picks);
  EXPECT_LT(found["rms_mm"].get<double>(), 1e-3);
  EXPECT_NEAR(found["matrix_mm"][2][3].get<double>(), 1400, 0.05);

  write_file(path("pairs.csv"), pairs);
  const nlohmann::json doubted = document({"frame", "points", "--pairs", path("pairs.csv")});
  EXPECT_GT(doubted["rms_mm"].get<double>(), 1);
  EXPECT_GT(doubted["residuals_mm"][4].get<double>(), 3);

  // In another order they are no shape that can be turned into the first.
  std::swap(picks[7], picks[10]);
  expect_refused(picks, "check their order");
  expect_refused(picks, "the largest at pixel");
  expect_refused({"frame", "planes", path("scan"), "--plane", "40x30+60+40", "--plane", "1x1+80+60",
                  "--plane", "30x30+90+60"},
                 "--plane 1x1+80+60: too few points for a plane: 1 of at least 3");

  write_file(path("pairs.csv"), "1,2,3\n");
  expect_refused({"frame", "points", "--pairs", path("pairs.csv")}, "line 1");
  write_file(path("pairs.csv"), "1,2,3,4,5,6\n1,2,nan,4,5,6\n");
  expect_refused({"frame", "points", "--pairs", path("pairs.csv")}, "line 2");
  expect_refused({"frame", "points", path("scan")}, "no points");
}

TEST_F(FrameProgram, FindsTheBoardWhereItIs) {
  expect_done({"simulate", path("boards"), "--boards", "1", "--corners", "13x9", "--spacing", "15",
               "--camera", "320x240"});
  const std::vector<std::string> board{"--corners", "13x9", "--spacing", "15"};
  std::vector<std::string> arguments{
      "frame", "board",           path("boards/board01"), "--scanner", path("boards/scanner.yaml"),
      "-o",    path("board.yaml")};
  arguments.insert(arguments.end(), board.begin(), board.end());
  const nlohmann::json found = document(arguments);
  EXPECT_EQ(found["corners"], 117);
  EXPECT_LT(found["rms_px"].get<double>(), 0.2);
  EXPECT_EQ(read_pose(path("board.yaml")).to, "board");

  // In its frame, the board's points lie in its plane.
  const nlohmann::json measured =
      document({"measure", path("boards/board01/x"), "--scanner", path("boards/scanner.yaml"),
                "--plane", "50x30+135+105", "--to-frame", path("board.yaml")});
  EXPECT_NEAR(measured["planes"][0]["centre_mm"][2].get<double>(), 0, 0.5);
  EXPECT_NEAR(measured["planes"][0]["normal"][2].get<double>(), -1, 1e-3);
}

TEST_F(FrameProgram, FindsTheMarkerWhereItIs) {
  // The markers of a ChArUco board, whose squares of 30 mm have them in the middle.
  expect_done({"simulate", path("boards"), "--boards", "1", "--board", "charuco", "--corners",
               "4x3", "--spacing", "40", "--camera", "640x480"});
  const std::string scanner = path("boards/scanner.yaml"), scan = path("boards/board01");
  const auto marker = [&](const std::string& family, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"frame",  "marker", scan,       "--scanner", scanner,
                                       "--side", "30",     "--family", family};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };

  // Marker 2 is in the square left of and below corner 0.
  const nlohmann::json found =
      document(marker("4x4", {"--number", "2", "-o", path("marker.yaml")}));
  EXPECT_EQ(found["marker"], 2);
  EXPECT_LT(found["rms_px"].get<double>(), 0.2);
  EXPECT_EQ(found["translation_deviation_mm"].size(), 3U);
  expect_done({"frame", "board", scan, "--scanner", scanner, "--board", "charuco", "--corners",
               "4x3", "--spacing", "40", "-o", path("board.yaml")});
  const Eigen::Isometry3d to_marker = read_pose(path("marker.yaml")).transform;
  const Eigen::Isometry3d to_board = read_pose(path("board.yaml")).transform;
  const Eigen::Isometry3d between = to_board * to_marker.inverse();
  EXPECT_LT((between.translation() - Eigen::Vector3d(-20, 20, 0)).norm(), 0.5)
      << between.translation().transpose();
  EXPECT_LT(angle_between(between.linear(), Eigen::Matrix3d::Identity()), 0.01);

  expect_refused(marker("4x4"), "choose one with --number");
  expect_refused(marker("4x4", {"--number", "77"}), "no marker 77 of 4x4 is visible");
  expect_refused(marker("36h11"), "no marker of 36h11 is visible");
  expect_refused(marker("9x9"), "36h11");
  expect_refused({"frame", "marker", scan, "--scanner", scanner, "--side", "-3"}, "--side -3");
}

TEST_F(FrameProgram, RigFileNamesThePose) {
  simulate("scan");
  write_file(path("rig.yaml"), "to_frame: base.yaml\n");
  expect_done({"reconstruct", path("scan"), "--rig", path("rig.yaml"), "-o", path("moved.pcd")});
  EXPECT_EQ(frame_name(read_cloud(path("moved.pcd")).cloud), "robot_base");
}

}  // namespace slipstream::frame_program_test
