// Runs `slipstream calibrate height` and `slipstream height`.
#include <regex>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "io/image_file.h"
#include "tests/app/program.h"

namespace slipstream::height_program_test {

class HeightProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  void simulate(const std::string& name, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"simulate", path(name), "--camera", "128x96",
                                       "--world",  "ideal",    "--high",   "16"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    ASSERT_EQ(run_program(arguments).exit_code, 0);
    const std::string scan = path(name) + "/scan.yaml";  // of an uncalibrated rig
    write_file(scan, std::regex_replace(contents(scan), std::regex("scanner:[^\n]*"), ""));
  }
  void take_planes() const {
    write_file(path("plane.obj"), "v -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\nf 1 2 3\nf 1 3 4\n");
    for (const int height : {0, 90, 180}) {
      simulate(fmt::format("plane{}", height), {"--mesh", path("plane.obj"), "--mesh-size", "2000",
                                                "--shift", "0", "0", std::to_string(60 - height)});
    }
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(HeightProgram, CalibratesAndMeasures) {
  take_planes();
  const ProgramRun calibrated =
      run_program({"calibrate", "height", path("plane0"), path("plane90"), path("plane180"),
                   "--heights", "0,90,180", "-o", path("heights.npy"), "--json"});
  ASSERT_EQ(calibrated.exit_code, 0) << calibrated.err;
  const auto told = nlohmann::json::parse(calibrated.out);
  EXPECT_GT(told["pixels"], 10000);
  EXPECT_LT(told["planes"][1]["rms_mm"], 0.01);

  simulate("sphere", {"--scene", "sphere"});
  const ProgramRun run =
      run_program({"height", path("sphere"), "--calibration", path("heights.npy"), "-o",
                   path("height.tiff"), "--preview", path("height.png"), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err.find("warning"), std::string::npos) << run.err;
  const auto found = nlohmann::json::parse(run.out);
  EXPECT_GT(found["pixels"], 2800);
  const double truth = 660 - read_map(path("sphere/truth/depth.tiff"))(64, 49);
  EXPECT_NEAR(read_map(path("height.tiff"))(64, 49), truth, 1);
  EXPECT_TRUE(std::filesystem::exists(path("height.png")));

  simulate("other", {"--scene", "sphere", "--axis", "y"});
  const ProgramRun doubted = run_program(
      {"height", path("other"), "--calibration", path("heights.npy"), "-o", path("other.npy")});
  EXPECT_NE(doubted.err.find("axis differ"), std::string::npos) << doubted.err;
}

TEST_F(HeightProgram, TakesPhaseMapsAndRefusesWhatIsWrong) {
  std::vector<std::string> planes;
  for (const int height : {0, 10, 20}) {
    planes.push_back(path(std::to_string(height) + ".npy"));
    write_map(planes.back(), Image<double>({6, 4}, 3 + 0.5 * height));
  }
  const auto calibrate = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"calibrate", "height"};
    arguments.insert(arguments.end(), planes.begin(), planes.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  };
  ASSERT_EQ(calibrate({"--heights", "0,10,20", "-o", path("heights.npy")}).exit_code, 0);
  write_map(path("map.tiff"), Image<float>({6, 4}, 6));
  ASSERT_EQ(run_program({"height", path("map.tiff"), "--calibration", path("heights.npy"), "-o",
                         path("height.npy")})
                .exit_code,
            0);
  EXPECT_NEAR(read_map(path("height.npy"))(5, 3), 6, 1e-4);

  const auto refused = [&](const ProgramRun& run, const std::string& part) {
    EXPECT_EQ(run.exit_code, 2) << part;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(path("no.npy")));
  };
  const std::string no = path("no.npy"), map = path("map.tiff");
  refused(calibrate({"--heights", "0,10", "-o", no}), "each of 3 planes");
  refused(calibrate({"--heights", "0,10,x", "-o", no}), "each of 3 planes");
  refused(calibrate({"--heights", "0,10,10", "-o", no}), "different heights");
  refused(calibrate({"--heights", "0,10,20", "-o", path("no.yaml")}), ".npy");
  refused(run_program({"height", map, "--calibration", planes[0], "-o", no}), "five numbers");
  write_map(map, Image<float>({5, 4}));
  refused(run_program({"height", map, "--calibration", path("heights.npy"), "-o", no}), "5x4");
}

}  // namespace slipstream::height_program_test
