// Runs `simulate --boards --second-camera` and `calibrate geometry --more-cameras`.
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::several_cameras_program_test {
namespace fs = std::filesystem;

class SeveralCamerasProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_.path() / name).string();
  }

  /// Calibrates from boards/ and boards-2/, into rig.yaml and rig-2.yaml.
  [[nodiscard]] ProgramRun calibrate(std::vector<std::string> more) const {
    std::vector<std::string> arguments{"calibrate",
                                       "geometry",
                                       path("boards"),
                                       "--more-cameras",
                                       path("boards-2"),
                                       "--corners",
                                       "7x5",
                                       "--spacing",
                                       "22",
                                       "-o",
                                       path("rig.yaml")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }

  TemporaryFolder folder_;
};

TEST_F(SeveralCamerasProgram, CalibratesTwoCamerasOfVirtualBoards) {
  // The second camera's folder stands beside the first one, also with a slash at its end.
  const ProgramRun simulated =
      run_program({"simulate", path("boards/"), "--boards", "5", "--second-camera", "--corners",
                   "7x5", "--spacing", "22", "--camera", "320x240", "--strategy", "dual-frequency",
                   "--high", "8", "--json"});
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  EXPECT_EQ(nlohmann::json::parse(simulated.out)["second_folder"], path("boards-2"));
  ASSERT_TRUE(fs::exists(path("boards-2/board05/y/scan.yaml")));

  const ProgramRun run = calibrate({"--camera-distortion", "2", "--projector-distortion", "2",
                                    "--save-points", path("points.csv"), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("points: " + path("points.csv")), std::string::npos) << run.err;
  const auto document = nlohmann::json::parse(run.out);
  ASSERT_EQ(document["more_cameras"].size(), 1U);
  EXPECT_EQ(document["more_cameras"][0]["scanner"], path("rig-2.yaml"));
  EXPECT_EQ(document["more_cameras"][0]["pose"]["translation_mm"].size(), 3U);

  // Both files know the projector alike, and each its own camera.
  const Scanner first = read_scanner(path("rig.yaml")), second = read_scanner(path("rig-2.yaml"));
  EXPECT_TRUE(first.projector.intrinsic.isApprox(second.projector.intrinsic, 1e-9));
  for (const auto& [found, folder] : {std::pair(first, "boards"), std::pair(second, "boards-2")}) {
    const Scanner truth = read_scanner(path(folder) + "/scanner.yaml");
    EXPECT_NEAR(found.translation.norm(), truth.translation.norm(), 20) << folder;
  }
}

TEST_F(SeveralCamerasProgram, RefusesBeforeItLooksAtPictures) {
  fs::create_directory(path("boards"));
  fs::create_directory(path("boards-2"));

  // The further camera's scanner file exists and cannot be read.
  write_file(path("rig-2.yaml"), "no scanner");
  const ProgramRun damaged = calibrate({});
  EXPECT_EQ(damaged.exit_code, 2) << damaged.err;
  EXPECT_NE(damaged.err.find("rig-2.yaml"), std::string::npos) << damaged.err;

  const ProgramRun with_maps = calibrate({"--residual"});
  EXPECT_EQ(with_maps.exit_code, 2) << with_maps.err;
  EXPECT_NE(with_maps.err.find("--residual"), std::string::npos) << with_maps.err;
}

}  // namespace slipstream::several_cameras_program_test
