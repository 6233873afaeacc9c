// Runs `slipstream merge` on clouds of a virtual object.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "geometry/rotation.h"
#include "io/file.h"
#include "io/pose_file.h"
#include "slipstream/cloud_file.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"
#include "tests/merge/virtual_shots.h"
#include "tests/shared_data.h"

namespace slipstream::merge_program_test {

class MergeProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  /// Writes a cloud of the object as seen at `pose`.
  std::string shot(const std::string& name, const Mesh& mesh, const Eigen::Isometry3d& pose,
                   double unit = 1) const {
    Shot shot = shot_of(MeshTree(mesh), pose, 0.05, static_cast<unsigned>(name.size()));
    for (Image<float>* image : {&shot.cloud.x, &shot.cloud.y, &shot.cloud.z}) {
      for (float& value : *image) value /= static_cast<float>(unit);
    }
    write_cloud(path(name), shot.cloud);
    return path(name);
  }

 private:
  TemporaryFolder folder_;
};

const Eigen::Isometry3d first_pose = before_camera(turned({0, 1, 0}, 0));
const Eigen::Isometry3d second_pose = before_camera(turned({0, 1, 0.3}, 20));

TEST_F(MergeProgram, JoinsTwoCloudsToAModel) {
  const ProgramRun run = run_program(
      {"merge", shot("a.ply", relief(), first_pose), shot("bb.ply", relief(), second_pose), "-o",
       path("model.ply"), "--mesh", path("model.stl"), "--fill-holes", "5", "--poses",
       path("poses.txt"), "--report", path("report.html"), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;

  const auto document = nlohmann::json::parse(run.out);
  EXPECT_EQ(document["joined"], 2);
  EXPECT_TRUE(document.contains("filled_holes"));
  const Eigen::Isometry3d truth = first_pose * second_pose.inverse();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      EXPECT_NEAR(document["views"][1]["pose"][row][column].get<double>(), truth(row, column), 0.5);
    }
  }
  EXPECT_LT(document["pairs"][0]["median_mm"], 0.2);
  EXPECT_EQ(point_count(read_cloud(path("model.ply")).cloud), document["points"]);
  EXPECT_GT(point_count(read_cloud(path("model.stl")).cloud), 1000U);
  EXPECT_NE(contents(path("report.html")).find("No pair closes a loop"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(path("merge-overlap.png"))) << "it is in the page";

  // The written poses are a start for the same views, in the sense in which they were written.
  const ProgramRun again =
      run_program({"merge", path("a.ply"), path("bb.ply"), "--start", path("poses.txt"), "--json"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out)["start"]["sense"],
            "quaternion x y z w, from the view's frame to the model's");
}

TEST_F(MergeProgram, FindsTheAxisOfATurntable) {
  constexpr double step = 20;
  const Mesh statue = large_statue();
  const Eigen::Vector3d up = -Eigen::Vector3d::UnitY();
  const Eigen::Vector3d middle(4, 0, 603);

  std::vector<std::string> arguments{"merge"};
  for (int view = 0; view < 4; ++view) {
    const Eigen::Isometry3d turn =
        Eigen::Translation3d(middle) * turned(up, step * view) * Eigen::Translation3d(-middle);
    const std::string name = fmt::format("{}.ply", std::string(view + 1, 'v'));
    arguments.push_back(shot(name, statue, turn * first_pose));
  }
  arguments.insert(arguments.end(), {"--turntable", "-o", path("model.ply")});
  const ProgramRun text = run_program(arguments);
  EXPECT_NE(text.out.find("before the turntable"), std::string::npos) << text.out << text.err;

  arguments.emplace_back("--json");
  const ProgramRun run = run_program(arguments);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto document = nlohmann::json::parse(run.out);
  EXPECT_EQ(document["joined"], 4);
  EXPECT_FALSE(document.contains("moved")) << document["moved"];

  // The axis may point either way; the step's sign says which.
  const auto& table = document["turntable"];
  EXPECT_EQ(table["angles_deg"].size(), 4U);
  EXPECT_NEAR(std::abs(table["step_deg"].get<double>()), step, 0.2);
  EXPECT_GT(std::abs(table["direction"][1].get<double>()), 0.999);
}

TEST_F(MergeProgram, NamesTheViewOfAnObjectThatBentMeanwhile) {
  const ProgramRun run = run_program(
      {"merge", shot("a.ply", relief(), first_pose), shot("bb.ply", relief(1), second_pose),
       shot("ccc.ply", relief(3), first_pose), "-o", path("model.ply")});
  EXPECT_EQ(run.exit_code, 2);
  for (const std::string& words : {path("ccc.ply") + " does not join the others",
                                   std::string("differ by more than the noise")}) {
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
  }
}

TEST_F(MergeProgram, RefusesPlanesAndWritesNothing) {
  const Mesh plane = plate([](double, double) { return 0.0; });
  const ProgramRun run = run_program({"merge", shot("a.ply", plane, first_pose),
                                      shot("bb.ply", plane, second_pose), "-o", path("model.ply")});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("slides"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("if that is a background, --box"), std::string::npos) << run.err;
  EXPECT_FALSE(std::filesystem::exists(path("model.ply")));
}

/// A relief before a wall that does not turn with it, in the camera's frame.
Mesh relief_before_wall(const Eigen::Isometry3d& pose) {
  Mesh scene = relief();
  for (Eigen::Vector3d& vertex : scene.vertices) vertex = pose * vertex;

  append_surface(scene, 1, 1, [](double u, double v) {
    return Eigen::Vector3d(270 * (u - 0.5), 270 * (v - 0.5), 690);
  });
  return scene;
}

TEST_F(MergeProgram, CutsOffTheWallBehindAnObjectThatTurns) {
  const Eigen::Isometry3d still = Eigen::Isometry3d::Identity();
  const std::vector<std::string> views{
      "merge", shot("a.ply", relief_before_wall(first_pose), still),
      shot("bb.ply", relief_before_wall(second_pose), still), "--json"};

  const ProgramRun whole = run_program(views);
  EXPECT_EQ(whole.exit_code, 2) << whole.out;
  for (const std::string words :
       {"a part of the scene moved between the views", "--box keeps the object alone"}) {
    EXPECT_NE(whole.err.find(words), std::string::npos) << whole.err;
  }

  std::vector<std::string> cut = views;
  cut.insert(cut.end(), {"--box", "-200,-200,500,200,200,670"});
  const ProgramRun run = run_program(cut);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto document = nlohmann::json::parse(run.out);
  const Eigen::Isometry3d truth = first_pose * second_pose.inverse();
  EXPECT_NEAR(document["views"][1]["pose"][0][0].get<double>(), truth(0, 0), 1e-3);
  EXPECT_NEAR(document["views"][1]["pose"][0][3].get<double>(), truth(0, 3), 0.5);
}

TEST_F(MergeProgram, RefusesFlagsOfScansForClouds) {
  const ProgramRun run = run_program({"merge", shot("a.ply", relief(), first_pose),
                                      shot("bb.ply", relief(), second_pose), "--farthest", "600"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("a.ply: --farthest applies to scans only"), std::string::npos) << run.err;
}

TEST_F(MergeProgram, JoinsTheScansAndCloudsOfARealTurntable) {
  const std::filesystem::path set = shared_data() / "sltk";
  if (!exists(set)) GTEST_SKIP() << set << " is missing";

  // The clouds' author has y and z point the other way.
  const std::vector<std::vector<std::string>> inputs{
      {set / "scan_0020", set / "scan_0021", "--order", "0-21", "--strategy", "gray", "--stripe",
       "1", "--reference", "inverse", "--projector", "1280x800", "--scanner",
       set / "procam_2016_12_09.yaml", "--box", "-290,-40,0,-60,400,730"},
      {set / "scan_0020_cloud.ply", set / "scan_0021_cloud.ply", "--box",
       "-290,-400,-730,-60,40,0"}};

  for (const std::vector<std::string>& input : inputs) {
    SCOPED_TRACE(input.front());
    std::vector<std::string> arguments{"merge", "-o", path("model.ply"), "--json"};
    arguments.insert(arguments.end(), input.begin(), input.end());
    const ProgramRun run = run_program(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;

    // The turn, by the trace of its matrix.
    const auto document = nlohmann::json::parse(run.out);
    const auto& pose = document["views"][1]["pose"];
    double trace = 0;
    for (int i = 0; i < 3; ++i) trace += pose[i][i].get<double>();
    EXPECT_NEAR(std::acos((trace - 1) / 2) * 180 / std::numbers::pi, 1.381, 0.02);
    EXPECT_LT(document["pairs"][0]["rms_mm"].get<double>(), 0.22);
  }

  // The last of them, the clouds, have colours.
  const Cloud model = read_cloud(path("model.ply")).cloud;
  EXPECT_TRUE(std::ranges::any_of(
      model.colour, [](const Colour& colour) { return colour.red > colour.blue + 40; }));
}

TEST_F(MergeProgram, ReadsMetresAndNamesMixedUnits) {
  const std::string metres = shot("a.ply", relief(), first_pose, 1000);
  const ProgramRun run = run_program({"merge", metres, shot("bb.ply", relief(), second_pose, 1000),
                                      "--unit", "m", "--poses", path("poses.txt")});
  EXPECT_EQ(run.exit_code, 0) << run.err;

  // The poses are in metres, too.
  EXPECT_NE(contents(path("poses.txt")).find("x y z (m)"), std::string::npos);
  const ProgramRun again = run_program(
      {"merge", metres, path("bb.ply"), "--unit", "m", "--start", path("poses.txt"), "--json"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out)["joined"], 2);

  const ProgramRun mixed = run_program({"merge", metres, shot("ccc.ply", relief(), second_pose)});
  EXPECT_EQ(mixed.exit_code, 2);
  EXPECT_NE(mixed.err.find("another unit"), std::string::npos) << mixed.err;
}

TEST_F(MergeProgram, BringsTheModelToAFrame) {
  const FramePose base{"camera", "robot_base",
                       pose_from(turned({1, 0, 0}, 90).linear(), {100, -200, 300})};
  write_pose(path("base.yaml"), base);
  const ProgramRun run = run_program(
      {"merge", shot("a.ply", relief(), first_pose), shot("bb.ply", relief(), second_pose), "-o",
       path("model.ply"), "--to-frame", path("base.yaml"), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;

  // The first view's camera has the given pose.
  const auto document = nlohmann::json::parse(run.out);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      EXPECT_NEAR(document["views"][0]["pose"][row][column].get<double>(),
                  base.transform(row, column), 1e-6);
    }
  }
  EXPECT_EQ(frame_name(read_cloud(path("model.ply")).cloud), "robot_base");
}

TEST_F(MergeProgram, TakesCloudsOfAnotherFrameBackToTheirCamera) {
  const std::string first = shot("a.ply", relief(), first_pose);
  Cloud moved = read_cloud(first).cloud;
  move_to_frame(
      moved, {"camera", "robot_base", pose_from(turned({1, 0, 0}, 90).linear(), {100, -200, 300})});
  write_cloud(path("moved.ply"), moved);

  const ProgramRun run =
      run_program({"merge", path("moved.ply"), shot("bb.ply", relief(), second_pose), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto document = nlohmann::json::parse(run.out);
  const Eigen::Isometry3d truth = first_pose * second_pose.inverse();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      EXPECT_NEAR(document["views"][1]["pose"][row][column].get<double>(), truth(row, column), 0.5);
    }
  }
}

TEST_F(MergeProgram, RefusesAModelMuchFinerThanTheViews) {
  const ProgramRun run = run_program({"merge", shot("a.ply", relief(), first_pose),
                                      shot("bb.ply", relief(), second_pose), "-o",
                                      path("model.ply"), "--spacing", "0.01"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("mm apart"), std::string::npos) << run.err;
}

TEST_F(MergeProgram, WritesAllOutputsOrNone) {
  const ProgramRun run = run_program(
      {"merge", shot("a.ply", relief(), first_pose), shot("bb.ply", relief(), second_pose), "-o",
       path("model.ply"), "--mesh", path("model.stl"), "--spacing", "5000"});
  EXPECT_EQ(std::filesystem::exists(path("model.ply")), run.exit_code == 0) << run.err;
  EXPECT_EQ(std::filesystem::exists(path("model.stl")), run.exit_code == 0) << run.err;
}

TEST_F(MergeProgram, RefusesAStartPoseForTwoViews) {
  std::filesystem::create_directory(path("x"));
  std::filesystem::create_directory(path("y"));
  write_file(path("poses.txt"), "a.ply 0 0 0 0 0 0 1\n");
  const ProgramRun run =
      run_program({"merge", shot("x/a.ply", relief(), first_pose),
                   shot("y/a.ply", relief(), second_pose), "--start", path("poses.txt")});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("for two views"), std::string::npos) << run.err;
}

}  // namespace slipstream::merge_program_test
