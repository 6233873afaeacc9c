// Two calibrated cameras and a projector of unknown calibration.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "io/opencv_storage.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::without_projector_test {
namespace fs = std::filesystem;

StoredMatrix stored(const auto& matrix) {
  StoredMatrix result{static_cast<int>(matrix.rows()), static_cast<int>(matrix.cols())};
  for (const auto& row : matrix.rowwise()) {
    result.numbers.insert(result.numbers.end(), row.begin(), row.end());
  }
  return result;
}

StoredMatrix stored(const Distortion& distortion) {
  const auto& k = distortion.coefficients;
  return {1, static_cast<int>(k.size()), {k.begin(), k.end()}};
}

/// A scan of both cameras in scan/, and their calibration without the projector in pair.yaml, by
/// slipstream's names, and in opencv.yaml.
class WithoutProjector : public testing::Test {
 protected:
  void SetUp() override { simulate({"--strategy", "gray-phase"}); }

  void simulate(std::vector<std::string> flags) {
    fs::remove_all(path("scan"));
    flags.insert(flags.end(), {"--scene", "board", "--camera", "160x120", "--second-camera"});
    flags.insert(flags.begin(), {"simulate", path("scan")});
    const ProgramRun run = run_program(flags);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Scanner first = read_scanner(path("scan/scanner.yaml"));
    const Scanner second = read_scanner(path("scan/second/scanner.yaml"));
    const Eigen::Matrix3d rotation = second.rotation.transpose() * first.rotation;
    const Eigen::Vector3d translation =
        second.rotation.transpose() * (first.translation - second.translation);
    baselines_ = translation.norm() / first.translation.norm();
    const auto write = [&](const char* file, const std::vector<std::string>& names) {
      write_file(path(file), new_storage({{names[0], stored(first.camera.intrinsic)},
                                          {names[1], stored(first.camera.distortion)},
                                          {names[2], stored(second.camera.intrinsic)},
                                          {names[3], stored(second.camera.distortion)},
                                          {names[4], stored(rotation)},
                                          {names[5], stored(translation)},
                                          {"noise_variance", {1, 1, {1.6}}}},
                                         false));
    };
    write("pair.yaml", {"camera_matrix", "camera_distortion", "second_camera_matrix",
                        "second_camera_distortion", "rotation", "translation"});
    write("opencv.yaml",
          {"cameraMatrix1", "distCoeffs1", "cameraMatrix2", "distCoeffs2", "R", "T"});
  }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  [[nodiscard]] nlohmann::json reconstructed(const std::vector<std::string>& flags) const {
    std::vector<std::string> arguments{"reconstruct", path("scan"), "--json"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return nlohmann::json::parse(run.out)["scans"][0];
  }

  /// The one line of a command that fails.
  [[nodiscard]] static std::string refusal(const std::vector<std::string>& arguments) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 2) << run.out;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    return run.err;
  }

  TemporaryFolder folder_;
  double baselines_ = 1;  ///< that of the cameras over the first's to the projector
};

TEST_F(WithoutProjector, IsAsExactAsTheProjectorAtTheSameBaseline) {
  const nlohmann::json one = reconstructed({"--one-camera"});
  const nlohmann::json two =
      reconstructed({"--scanner", path("pair.yaml"), "--uncertainty", "-o", path("cloud.ply")});
  EXPECT_EQ(two["backend"], "coordinates");
  EXPECT_GT(two["points"], 0.95 * one["points"].get<double>());
  const double rms = two["rms_mm"].get<double>();
  EXPECT_LT(baselines_ * rms, 1.5 * one["rms_mm"].get<double>());
  EXPECT_NEAR(two["median_sigma_z_mm"].get<double>(), rms, 0.5 * rms);
  EXPECT_NEAR(two["baseline_mm"].get<double>(), baselines_ * one["baseline_mm"].get<double>(), 1);
  EXPECT_TRUE(fs::exists(path("cloud.ply")));
}

TEST_F(WithoutProjector, ReadsOpenCVsNamesIfTheSecondCameraHasNoScanner) {
  const nlohmann::json named = reconstructed({"--scanner", path("pair.yaml")});
  fs::remove(path("scan/second/scanner.yaml"));
  std::string description = contents(path("scan/second/scan.yaml"));
  const std::size_t line = description.find("scanner:");
  description.erase(line, description.find('\n', line) + 1 - line);
  write_file(path("scan/second/scan.yaml"), description);
  EXPECT_EQ(reconstructed({"--scanner", path("opencv.yaml")})["points"], named["points"]);
  EXPECT_NE(refusal({"reconstruct", path("scan")}).find("--second-scanner"), std::string::npos);
}

TEST_F(WithoutProjector, IsRefusedWhereTheProjectorIsNeeded) {
  for (std::vector<std::string> command :
       {std::vector<std::string>{"reconstruct", path("scan"), "--one-camera"},
        {"measure", path("scan"), "--point", "80,60"},
        {"view", path("scan"), "--snapshot", path("view.png")},
        {"live", "--source", "replay:" + path("scan"), "--headless", "--frames", "1"},
        {"simulate", path("new")}}) {
    command.insert(command.end(), {"--scanner", path("pair.yaml")});
    EXPECT_NE(refusal(command).find("two cameras and no projector"), std::string::npos)
        << command[0];
  }
  const ProgramRun check = run_program({"check", path("scan"), "--scanner", path("pair.yaml")});
  EXPECT_EQ(check.exit_code, 0) << check.err;
}

TEST_F(WithoutProjector, NeedsACoordinate) {
  simulate({"--strategy", "pmp", "--frequency", "8", "--steps", "4"});
  EXPECT_NE(refusal({"reconstruct", path("scan"), "--scanner", path("pair.yaml")})
                .find("only a wrapped phase"),
            std::string::npos);
}

}  // namespace slipstream::without_projector_test
