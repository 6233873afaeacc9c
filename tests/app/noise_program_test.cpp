// Runs calibrate ambient, calibrate noise, reconstruct --uncertainty, design and reproduce.
#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::noise_program_test {

class NoiseProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_.path() / name).string();
  }
  /// Simulates a board; the camera subtracts an offset, and `seed` seeds its noise.
  void simulate(const std::string& name, const std::vector<std::string>& strategy,
                const std::string& seed) const {
    std::vector<std::string> arguments{
        "simulate",          path(name), "--scene",         "board", "--camera", "160x120",
        "--world",           "ideal",    "--alpha-p",       "200",   "--beta-p", "40",
        "--virtual-ambient", "-5",       "--virtual-noise", "2",     "--seed",   seed};
    arguments.insert(arguments.end(), strategy.begin(), strategy.end());
    const ProgramRun run = run_program(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(NoiseProgram, CalibratesAmbientLightAndNoiseIntoTheScannerFile) {
  const std::vector<std::string> four{"--strategy", "pmp", "--steps", "4"};
  simulate("one", four, "1");
  simulate("two", four, "2");
  simulate("cued", {"--strategy", "pcmp", "--steps", "3"}, "3");
  const std::string file = path("scanner.yaml");

  const ProgramRun ambient = run_program({"calibrate", "ambient", path("one"), path("two"),
                                          "--histogram", path("ambient.png"), "-o", file});
  ASSERT_EQ(ambient.exit_code, 0) << ambient.err;
  const ProgramRun noise = run_program(
      {"calibrate", "noise", path("one"), path("two"), "--scanner", file, "-o", file, "--json"});
  ASSERT_EQ(noise.exit_code, 0) << noise.err;
  for (const char* const equation : {"3.20", "3.79", "3.82"}) {
    EXPECT_NE(noise.out.find(equation), std::string::npos) << equation << noise.out;
  }
  const PhotometricCalibration read = read_photometric_calibration(file);
  EXPECT_NEAR(read.ambient.value_or(0), -5, 0.2);
  EXPECT_NEAR(read.noise_variance.value_or(0), 2.083, 0.1);
  EXPECT_NO_THROW(read_scanner(file)) << "all else stays";

  const ProgramRun cloud = run_program({"reconstruct", path("cued"), "--scanner", file,
                                        "--uncertainty", "-o", path("cloud.ply"), "--json"});
  EXPECT_EQ(cloud.exit_code, 0) << cloud.err;
  EXPECT_NE(cloud.out.find("median_sigma_z_mm"), std::string::npos) << cloud.out;
  EXPECT_NE(cloud.out.find("\"total_mm\""), std::string::npos) << cloud.out;
}

TEST_F(NoiseProgram, AmbientLightTakesTheResponseFirst) {
  const std::string scan = path("bent"), file = path("bent.yaml");
  ASSERT_EQ(
      run_program(
          {"simulate",        scan,    "--scene",         "board", "--camera",          "160x120",
           "--world",         "ideal", "--strategy",      "pmp",   "--steps",           "8",
           "--alpha-p",       "200",   "--beta-p",        "0",     "--virtual-ambient", "5",
           "--virtual-noise", "1",     "--virtual-gamma", "2.2"})
          .exit_code,
      0);
  const ProgramRun refused = run_program({"calibrate", "ambient", scan, "-o", file});
  EXPECT_EQ(refused.exit_code, 2) << refused.out;
  EXPECT_NE(refused.err.find("calibrate gamma"), std::string::npos) << refused.err;
  EXPECT_THROW((void)read_photometric_calibration(file), Error) << "a file was written";

  ASSERT_EQ(run_program({"calibrate", "gamma", scan, "-o", file}).exit_code, 0);
  const ProgramRun known =
      run_program({"calibrate", "ambient", scan, "--scanner", file, "-o", file});
  ASSERT_EQ(known.exit_code, 0) << known.err;
  EXPECT_NEAR(read_photometric_calibration(file).ambient.value_or(0), 5, 0.5);
}

TEST_F(NoiseProgram, MeasuresNoiseOfOnePcmpScanAndWarnsOfIt) {
  simulate("cued", {"--strategy", "pcmp", "--steps", "5"}, "1");
  const ProgramRun run = run_program({"calibrate", "noise", path("cued")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("(3.99)"), std::string::npos) << run.out;
  EXPECT_NE(run.err.find("warning"), std::string::npos) << run.err;
}

TEST_F(NoiseProgram, SaysWhyMeasurementsDisagree) {
  const std::vector<std::string> bent{"--strategy",      "pmp", "--steps", "4",
                                      "--virtual-gamma", "1.2"};
  simulate("one", bent, "1");
  simulate("two", bent, "2");
  const ProgramRun run = run_program({"calibrate", "noise", path("one"), path("two")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("calibrate gamma"), std::string::npos) << run.out;
}

TEST_F(NoiseProgram, RefusesWhatCannotBeMeasured) {
  simulate("three", {"--strategy", "pmp", "--steps", "3"}, "1");
  simulate("cued", {"--strategy", "pcmp", "--steps", "3"}, "1");
  const auto expect_refused = [](const ProgramRun& run, const std::string& part) {
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
  };
  expect_refused(run_program({"calibrate", "noise", path("three")}), "two equal scans");
  expect_refused(
      run_program({"calibrate", "noise", path("three"), path("three"), "-o", path("s.yaml")}),
      "copies");
  expect_refused(run_program({"calibrate", "ambient", path("cued")}), "pcmp");
  expect_refused(run_program({"calibrate", "ambient", path("three"), "--least-reflectivity", "2"}),
                 "2");
  Scanner bare = read_scanner(path("cued") + "/scanner.yaml");
  bare.photometry = {};
  write_scanner(path("bare.yaml"), bare);
  expect_refused(run_program({"reconstruct", path("cued"), "--scanner", path("bare.yaml")}),
                 "calibrate ambient");
  const ProgramRun assumed =
      run_program({"reconstruct", path("three"), "--scanner", path("bare.yaml"), "--uncertainty"});
  EXPECT_EQ(assumed.exit_code, 0) << assumed.err;
  EXPECT_NE(assumed.err.find("1.6 assumed"), std::string::npos) << assumed.err;
  expect_refused(run_program({"design"}), "--noise-variance");
  expect_refused(run_program({"design", "--phase-speed", "0.1", "--frames", "8"}), "--frames");
  expect_refused(
      run_program({"design", "--noise-variance", "1", "--frames", "8", "--plot", "a.png"}),
      "--plot");
}

TEST_F(NoiseProgram, WarnsOfPatternsThatAreUnwise) {
  const ProgramRun unwise = run_program({"patterns", path("patterns"), "--strategy", "pcmp",
                                         "--steps", "3", "--high", "24", "--projector", "640x480"});
  EXPECT_EQ(unwise.exit_code, 0) << unwise.err;
  EXPECT_NE(unwise.err.find("warning"), std::string::npos) << unwise.err;
  const ProgramRun wise =
      run_program({"patterns", path("patterns"), "--strategy", "pcmp", "--projector", "640x480"});
  EXPECT_EQ(wise.err, "");
}

TEST_F(NoiseProgram, ProposesPatterns) {
  const ProgramRun run =
      run_program({"design", "--steps", "4", "--noise-variance", "1.55", "--ambient-light", "-7",
                   "--least-reflectivity", "0.3", "--plot", path("design.png"), "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  for (const char* const key : {"high", "share", "alpha_p", "beta_p", "success", "plot"}) {
    EXPECT_NE(run.out.find("\"" + std::string(key) + "\": "), std::string::npos) << key;
  }
}

}  // namespace slipstream::noise_program_test
