// Runs `slipstream measure` and `reconstruct --mesh`.
#include <cmath>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "slipstream/cloud_file.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::measure_program_test {

class MeasureProgram : public testing::Test {
 protected:
  void SetUp() override {
    const ProgramRun run = run_program({"simulate", path("scan"), "--scene", "sphere", "--camera",
                                        "320x240", "--virtual-noise", "1.5"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  [[nodiscard]] static nlohmann::json measured(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "measure");
    arguments.emplace_back("--json");
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.exit_code == 0 ? nlohmann::json::parse(run.out) : nlohmann::json();
  }

  static void expect_refused(const std::vector<std::string>& arguments, const std::string& part) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(run.out, "");
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(MeasureProgram, TellsTheSameOfAScanAndOfItsCloud) {
  const std::vector<std::string> asked{"--point",      "160,120", "--distance",
                                       "140,120",      "180,120", "--sphere",
                                       "80x80+120+80", "--plane", "9x9+156+116"};
  std::vector<std::string> of_scan{path("scan"), "--noise-variance", "1.6"};
  of_scan.insert(of_scan.end(), asked.begin(), asked.end());
  const nlohmann::json scan = measured(of_scan);
  EXPECT_EQ(scan["findings"], nlohmann::json::array());
  ASSERT_EQ(run_program({"reconstruct", path("scan"), "-o", path("cloud.pcd"), "--uncertainty",
                         "--noise-variance", "1.6"})
                .exit_code,
            0);
  std::vector<std::string> of_cloud{path("cloud.pcd")};
  of_cloud.insert(of_cloud.end(), asked.begin(), asked.end());
  const nlohmann::json cloud = measured(of_cloud);
  for (const char* const list : {"points", "distances", "spheres", "planes"}) {
    ASSERT_EQ(scan[list].size(), 1U);
    EXPECT_EQ(scan[list], cloud[list]) << list;
  }
  EXPECT_GT(scan["points"][0]["sigma_mm"][2], 0);
  const nlohmann::json& sphere = scan["spheres"][0];
  EXPECT_NEAR(sphere["rms_mm"].get<double>() / sphere["noise_mm"].get<double>(), 1, 0.15);
}

TEST_F(MeasureProgram, TellsThatBothAxesContradictTheCalibration) {
  ASSERT_EQ(
      run_program({"simulate", path("both"), "--axis", "both", "--camera", "160x120"}).exit_code,
      0);
  Scanner moved = read_scanner(path("both/scanner.yaml"));
  moved.translation += Eigen::Vector3d(0, 20, 0);
  write_scanner(path("both/scanner.yaml"), moved);
  const ProgramRun run =
      run_program({"convert", path("both"), "-o", path("both.ply"), "--anyway", "--json"});
  EXPECT_NE(run.err.find("do not meet in one projector pixel"), std::string::npos) << run.err;
}

TEST_F(MeasureProgram, RefusesWhatItCannotMeasure) {
  const std::string scan = path("scan");
  expect_refused({"measure", scan}, "nothing to measure");
  expect_refused({"measure", scan, "--point", "1;2"}, "'1;2' is not a pixel");
  expect_refused({"measure", scan, "--point", "12"}, "'12' is not a pixel");
  expect_refused({"measure", scan, "--point", "320,1"}, "outside the picture of 320x240");
  expect_refused({"measure", scan, "--point", "0,0"}, "no point: too dark");
  expect_refused({"measure", scan, "--plane", "12"}, "'12' is not a rectangle");
  expect_refused({"measure", scan, "--sphere", "3x1+0+0"}, "too few");
  ASSERT_EQ(run_program({"reconstruct", scan, "-o", path("cloud.ply")}).exit_code, 0);
  for (const char* const what : {"--point", "--plane", "--sphere"}) {
    const std::string where = what == std::string("--point") ? "1,1" : "9x9+1+1";
    expect_refused({"measure", path("cloud.ply"), what, where}, "organised .pcd");
  }
}

TEST_F(MeasureProgram, FitsToAllPointsOfWhateverReconstructWrites) {
  const nlohmann::json scan = measured({path("scan"), "--raw", "--plane", "all"})["planes"][0];
  for (const char* const name :
       {"c.pcd", "c.ply", "c.xyz", "mesh.ply", "mesh.stl", "mesh.obj", "mesh.glb"}) {
    const bool is_mesh = std::string(name).starts_with("mesh");
    ASSERT_EQ(
        run_program({"reconstruct", path("scan"), "--raw", is_mesh ? "--mesh" : "-o", path(name)})
            .exit_code,
        0);
    const nlohmann::json found = measured({path(name), "--plane", "all"});
    if (is_mesh) continue;  // leaves out points without a triangle
    for (const char* const key : {"points", "rms_mm"}) {
      EXPECT_NEAR(found["planes"][0][key].get<double>() / scan[key].get<double>(), 1, 1e-4) << name;
    }
  }
  for (const char* const name : {"c.pcd", "c.ply", "c.xyz", "mesh.stl", "mesh.obj", "mesh.glb"}) {
    const ProgramRun run = run_program({"convert", path(name), "-o", path("converted.ply")});
    EXPECT_EQ(run.exit_code, 0) << run.err;
  }
  // One row of points, as other programs write clouds without a grid.
  std::ofstream(path("row.pcd"))
      << "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 1\n"
         "POINTS 4\nDATA ascii\n0 0 5\n1 0 5\n0 1 5\n1 1 5\n";
  EXPECT_NEAR(measured({path("row.pcd"), "--plane", "all"})["planes"][0]["centre_mm"][2], 5, 1e-9);
  expect_refused({"measure", path("row.pcd"), "--distance", "0,0", "1,0"}, "organised .pcd");
}

TEST_F(MeasureProgram, ReconstructWritesMeshesByTheirEnding) {
  for (const char* const name : {"mesh.ply", "mesh.stl", "mesh.obj", "mesh.glb"}) {
    const ProgramRun run = run_program({"reconstruct", path("scan"), "--mesh", path(name)});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_GT(point_count(read_cloud(path(name)).cloud), 1000U) << name;
  }
  expect_refused({"reconstruct", path("scan"), "--mesh", path("mesh.fbx")},
                 "use .ply, .stl, .obj, .glb");
}

}  // namespace slipstream::measure_program_test
