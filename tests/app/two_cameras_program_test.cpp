// Runs `slipstream reconstruct` and `live` with a second camera.
#include <algorithm>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "slipstream/cloud_file.h"
#include "slipstream/scan_files.h"
#include "slipstream/scan_job.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"
#include "tests/shared_data.h"

namespace slipstream::two_cameras_program_test {
namespace fs = std::filesystem;

class TwoCamerasProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_.path() / name).string();
  }

  /// Simulates a scan of both cameras; returns its folder.
  [[nodiscard]] std::string scan(const std::vector<std::string>& patterns) const {
    std::vector<std::string> arguments{
        "simulate", path("scan"), "--second-camera", "--camera", "160x120", "--scene", "board"};
    arguments.insert(arguments.end(), patterns.begin(), patterns.end());
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return path("scan");
  }

  static nlohmann::json json_of(std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err << fmt::format("{}", fmt::join(arguments, " "));
    return nlohmann::json::parse(run.out);
  }

  TemporaryFolder folder_;
};

TEST_F(TwoCamerasProgram, LiveGivesTheCloudOfReconstruct) {
  for (const std::vector<std::string>& patterns :
       {std::vector<std::string>{"--strategy", "dual-frequency"},
        std::vector<std::string>{"--strategy", "dual-frequency", "--axis", "both"},
        std::vector<std::string>{"--strategy", "pcmp", "--steps", "5"}}) {
    const std::string folder = scan(patterns), what = fmt::format("{}", fmt::join(patterns, " "));
    const auto points =
        json_of({"reconstruct", folder, "-o", path("scan.ply")})["scans"][0]["points"];
    EXPECT_GT(points, 5000) << what;
    const auto live =
        json_of({"live", "--source", "replay:" + folder, "--second-camera",
                 "replay:" + folder + "/second", "--headless", "-o", path("live.ply")});
    EXPECT_EQ(live["clouds"], 1) << what;
    EXPECT_EQ(read_file(path("live.ply")), read_file(path("scan.ply"))) << what;
  }
}

TEST_F(TwoCamerasProgram, LiveFusesToTheCloudOfReconstruct) {
  for (const std::vector<std::string>& patterns :
       {std::vector<std::string>{"--strategy", "dual-frequency"},
        std::vector<std::string>{"--strategy", "pcmp", "--steps", "5"},
        std::vector<std::string>{"--strategy", "pmp", "--steps", "4", "--frequency", "16"}}) {
    const std::string folder = scan(patterns), what = fmt::format("{}", fmt::join(patterns, " "));
    const auto fused = json_of({"reconstruct", folder, "--fuse", "-o", path("scan.ply")});
    const auto live =
        json_of({"live", "--source", "replay:" + folder, "--second-camera",
                 "replay:" + folder + "/second", "--fuse", "--headless", "-o", path("live.ply")});
    EXPECT_GT(fused["scans"][0]["points"], 5000) << what;
    EXPECT_EQ(live["cleaned"]["valid"], fused["scans"][0]["points"]) << what;
    EXPECT_EQ(read_file(path("live.ply")), read_file(path("scan.ply"))) << what;
    EXPECT_TRUE(
        std::ranges::equal(bytes_of(run_program({"reconstruct", folder, "--fuse", "-o", "-"}).out),
                           read_file(path("scan.ply"))))
        << what;
  }
}

TEST_F(TwoCamerasProgram, LiveTellsWhyItDoesNotFuse) {
  const std::string folder = scan({"--strategy", "dual-frequency"});
  const ProgramRun run = run_program({"live", "--source", "replay:" + folder, "--second-camera",
                                      "replay:" + folder + "/second", "--fuse", "--nearest", "1",
                                      "--farthest", "2", "--headless", "-o", path("live.ply")});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("camera 1 measures only 0 points"), std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("the scan:"), std::string::npos) << run.err;
  EXPECT_NE(run.out.find("0 clouds"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("backend fused cameras"), std::string::npos) << run.out;
  EXPECT_FALSE(fs::exists(path("live.ply")));
}

TEST_F(TwoCamerasProgram, LiveReportsFramesOfTheSecondCameraThatDoNotFit) {
  const std::string folder = scan({"--strategy", "dual-frequency"});
  const fs::path second = fs::path(folder) / "second";
  fs::rename(second / "frame_00.png", second / "kept.png");
  fs::rename(second / "frame_01.png", second / "frame_00.png");
  fs::rename(second / "kept.png", second / "frame_01.png");

  const auto live = json_of({"live", "--source", "replay:" + folder, "--second-camera",
                             "replay:" + second.string(), "--fuse", "--headless"});
  const std::string findings = live["findings"].dump();
  EXPECT_NE(findings.find("camera 2"), std::string::npos) << findings;
  EXPECT_EQ(findings.find("--order"), std::string::npos) << findings;

  // The setting would reorder the first camera's frames, too.
  const ProgramRun run = run_program({"reconstruct", folder, "--fuse", "-o", path("scan.ply")});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err.find("--order"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("in its scan.yaml in the order"), std::string::npos) << run.err;
}

TEST_F(TwoCamerasProgram, MatchedCamerasRefuseReflectionAndContrast) {
  const std::string folder = scan({"--strategy", "dual-frequency"});
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"reconstruct", folder, "-o", path("scan.ply")},
        std::vector<std::string>{"live", "--source", "replay:" + folder, "--second-camera",
                                 "replay:" + folder + "/second", "--headless"}}) {
    for (const auto& [flags, said] : std::vector<std::pair<std::vector<std::string>, std::string>>{
             {{"--reflection", "3"}, "--reflection and --local-reflection need"},
             {{"--correct-contrast"}, "--correct-contrast needs one camera"}}) {
      std::vector<std::string> asked = arguments;
      asked.insert(asked.end(), flags.begin(), flags.end());
      const ProgramRun run = run_program(asked);
      EXPECT_EQ(run.exit_code, 2);
      EXPECT_NE(run.err.find(said), std::string::npos) << run.err;
    }
  }
}

TEST_F(TwoCamerasProgram, TheLibraryGivesTheCloudOfReconstruct) {
  for (const std::vector<std::string>& patterns :
       {std::vector<std::string>{"--strategy", "dual-frequency"},
        std::vector<std::string>{"--strategy", "dual-frequency", "--axis", "both"}}) {
    const std::string folder = scan(patterns);
    json_of({"reconstruct", folder, "-o", path("program.ply")});
    write_cloud(path("library.ply"), reconstruct(load_scan(folder)).cloud);
    EXPECT_EQ(read_file(path("library.ply")), read_file(path("program.ply")));
  }
}

TEST_F(TwoCamerasProgram, LiveTakesTwoVirtualCameras) {
  const auto live = json_of({"live",
                             "--source",
                             "virtual",
                             "--second-camera",
                             "virtual",
                             "--world",
                             "ideal",
                             "--scene",
                             "board",
                             "--move",
                             "0",
                             "0",
                             "0",
                             "--camera",
                             "160x120",
                             "--strategy",
                             "dual-frequency",
                             "--frames",
                             "36",
                             "--headless",
                             "-o",
                             path("live.ply")});
  EXPECT_EQ(live["frames"]["captured"], 36);
  EXPECT_EQ(live["clouds"], 31);
  EXPECT_GT(fs::file_size(path("live.ply")), 50000U);
}

TEST_F(TwoCamerasProgram, FlagsNameTheSecondCamera) {
  const std::string folder = scan({"--strategy", "dual-frequency"});
  const ProgramRun converted = run_program({"convert", folder, "-o", path("one.ply")});
  EXPECT_NE(converted.err.find("of one camera; the others are left out"), std::string::npos)
      << converted.err;
  const auto own = json_of({"reconstruct", folder, "-o", path("own.ply")});
  fs::rename(folder + "/second", path("other"));
  const auto named =
      json_of({"reconstruct", folder, "--second-camera", path("other"), "-o", path("named.ply")});
  EXPECT_EQ(named["scans"][0]["points"], own["scans"][0]["points"]);
  EXPECT_EQ(read_file(path("named.ply")), read_file(path("own.ply")));
}

TEST_F(TwoCamerasProgram, FusesThreeCamerasToOneCloud) {
  const std::string folder = scan({"--second-camera", "--strategy", "dual-frequency"});
  const auto fused = json_of(
      {"reconstruct", folder, "-o", path("fused.ply"), "--mesh", path("fused.stl")})["scans"][0];
  ASSERT_EQ(fused["points_of_cameras"].size(), 3U);

  // The points are evenly spaced, so they may be a few less than those of a camera that sees all.
  for (const auto& points : fused["points_of_cameras"]) {
    EXPECT_GT(fused["points"].get<double>(), 0.95 * points.get<double>());
  }
  EXPECT_EQ(point_count(read_cloud(path("fused.ply")).cloud), fused["points"]);
  EXPECT_GT(point_count(read_cloud(path("fused.stl")).cloud), 1000U);

  // Two only if asked for.
  const auto two = json_of({"reconstruct", folder + "/second", "--second-camera",
                            folder + "/camera-3", "--fuse", "-o", path("two.ply")})["scans"][0];
  EXPECT_EQ(two["points_of_cameras"].size(), 2U);

  const ProgramRun alone =
      run_program({"reconstruct", folder, "--one-camera", "--fuse", "-o", path("one.ply")});
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_NE(alone.err.find("--fuse"), std::string::npos) << alone.err;
}

TEST_F(TwoCamerasProgram, ARealHandNeedsNeitherDepthsNorOrigin) {
  const fs::path hand = shared_data() / "bsc-hand";
  if (!fs::exists(hand)) GTEST_SKIP() << hand << " is not there";
  for (const char* camera : {"1", "2"}) {
    std::string scanner =
        "%YAML:1.0\n---\nprojector_width: 1280\nprojector_height: 800\ncamera_width: 640\n"
        "camera_height: 480\n";
    for (const auto& [entry, file] :
         {std::pair<std::string, std::string>{"camera_projection",
                                              fmt::format("mCamera{}Rectified.txt", camera)},
          std::pair<std::string, std::string>{"projector_projection", "mProjector.txt"}}) {
      std::ifstream text(hand / file);
      std::vector<std::string> numbers(12);
      for (std::string& number : numbers) text >> number;
      scanner +=
          fmt::format("{}: !!opencv-matrix\n   rows: 3\n   cols: 4\n   dt: d\n   data: [ {} ]\n",
                      entry, fmt::join(numbers, ", "));
    }
    write_file(path(fmt::format("camera{}.yaml", camera)), scanner);
  }
  std::vector<std::string> arguments{"reconstruct",      (hand / "cam1").string(),
                                     "--second-camera",  (hand / "cam2").string(),
                                     "--scanner",        path("camera1.yaml"),
                                     "--second-scanner", path("camera2.yaml"),
                                     "--strategy",       "pmp",
                                     "--steps",          "4",
                                     "--frequency",      "28.5",
                                     "--motion",         "2",
                                     "--windows",        "2:3"};
  const auto told = json_of(arguments);
  // Each camera resolves the other's fringe orders, and all points become one cloud.
  arguments.insert(arguments.end(), {"--fuse", "-o", path("fused.ply")});
  const auto fused = json_of(arguments)["scans"][0];
  for (const auto& points : fused["points_of_cameras"]) EXPECT_GT(fused["points"], points);

  const auto& scan = told["scans"][0];
  const double points = scan["points"], pixels = scan["pixels"];
  const double dark = scan["counts"]["too dark"];
  EXPECT_GT(points, 0.9 * (pixels - dark));
  EXPECT_EQ(scan["findings"].size(), 1U);
}

TEST_F(TwoCamerasProgram, LiveDoesNotRecordTwoCameras) {
  const ProgramRun run =
      run_program({"live", "--source", "virtual", "--camera", "64x48", "--headless",
                   "--second-camera", "virtual", "--record", path("x.slip")});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("--second-camera"), std::string::npos) << run.err;
}

}  // namespace slipstream::two_cameras_program_test
