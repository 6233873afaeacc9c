// Runs `slipstream calibrate residual`, on virtual scans and a real one.
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"
#include "tests/shared_data.h"

namespace slipstream::calibrate_residual_program_test {
namespace fs = std::filesystem;

/// Of the line that begins with these words, the number after "held-out blocks off by".
double held_out(const std::string& out, const std::string& beginning) {
  const std::string words = beginning + ": held-out blocks off by ";
  const std::size_t at = out.find(words);
  return at == std::string::npos ? -1 : std::stod(out.substr(at + words.size()));
}

/// The same for the degree that was chosen.
double held_out_by_map(const std::string& out) {
  const std::string words = "scanner file with the map of degree ";
  const std::size_t at = out.find(words);
  if (at == std::string::npos) return -1;
  return held_out(out, fmt::format("a map of degree {}", out[at + words.size()]));
}

class CalibrateResidualProgram : public testing::Test {
 protected:
  [[nodiscard]] fs::path path(const std::string& name) const { return folder_.path() / name; }

 private:
  TemporaryFolder folder_;
};

TEST_F(CalibrateResidualProgram, FindsALensThatIsALittleOff) {
  ASSERT_EQ(run_program({"simulate", path("scan"), "--scene", "board", "--axis", "both", "--world",
                         "ideal", "--camera", "640x480"})
                .exit_code,
            0);
  Scanner scanner = read_scanner(path("scan") / "scanner.yaml");
  write_scanner(path("right.yaml"), scanner);
  scanner.projector.distortion.coefficients[0] -= 0.005;
  write_scanner(path("off.yaml"), scanner);

  // 1. The map is found, kept in the file, and used.
  const ProgramRun run =
      run_program({"calibrate", "residual", path("scan"), "--scanner", path("off.yaml"), "-o",
                   path("mapped.yaml"), "--picture", path("residual.png")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LT(held_out_by_map(run.out), held_out(run.out, "no map") / 2) << run.out;
  const Scanner mapped = read_scanner(path("mapped.yaml"));
  EXPECT_FALSE(mapped.camera.residual.terms.empty());
  EXPECT_TRUE(mapped.projector.residual.terms.empty());
  EXPECT_TRUE(fs::exists(path("residual.png")));

  const ProgramRun again = run_program({"calibrate", "residual", path("scan"), "--scanner",
                                        path("mapped.yaml"), "-o", path("again.yaml")});
  EXPECT_EQ(again.exit_code, 0) << again.err;

  // 2. A picture of another type is refused before the file is written.
  const ProgramRun refused =
      run_program({"calibrate", "residual", path("scan"), "--scanner", path("off.yaml"), "-o",
                   path("none.yaml"), "--picture", path("residual.jpg")});
  EXPECT_EQ(refused.exit_code, 2) << refused.err;
  EXPECT_FALSE(fs::exists(path("none.yaml")));

  // 3. Where nothing is left, nothing is written.
  const ProgramRun right = run_program({"calibrate", "residual", path("scan"), "--scanner",
                                        path("right.yaml"), "-o", path("none.yaml")});
  EXPECT_EQ(right.exit_code, 2);
  EXPECT_NE(right.err.find("no residual map is supported"), std::string::npos) << right.err;
  EXPECT_FALSE(fs::exists(path("none.yaml")));
}

/// The calibration of `cam_proj_param.npz`.
Scanner scanner_of_masks() {
  Scanner scanner;
  scanner.camera.intrinsic << 3321.1736373315334, 0, 617.1600085846413, 0, 3331.975553567659,
      521.9504655613476, 0, 0, 1;
  scanner.camera.distortion =
      make_distortion(std::vector{-0.14781612370032168, 2.4090198034141843, -0.0023683594901660063,
                                  -0.0019516596834823427, -35.227855966016016});
  scanner.camera.size = {1280, 1024};

  scanner.projector.intrinsic << 1926.6721527274262, 0, 618.3991715461265, 0, 1932.84278366411,
      774.0750552404426, 0, 0, 1;
  scanner.projector.distortion =
      make_distortion(std::vector{0.006957293561705816, 0.000283014618405258, -0.001361311859324052,
                                  -0.0017330929103798395, -0.725272917201371});
  scanner.projector.size = {1280, 800};

  scanner.rotation << 0.9985077509412551, 0.012670928979744799, 0.05311985381217353,
      -0.004741914914324836, 0.9891530007404401, -0.14681231341113146, -0.05440391119378943,
      0.14634134304759286, 0.9877370225732379;
  scanner.translation = {-86.78861799693547, -11.655578498302187, -12.122077805606816};
  return scanner;
}

// Masks and a lion by 18 one-bit steps and Gray codes: on blocks that the map was not fitted to,
// the deviation of the median distances falls by half.
TEST_F(CalibrateResidualProgram, HalvesWhatARealRigLeavesOver) {
  const fs::path pictures = shared_data() / "stsiva" / "images";
  if (!fs::exists(pictures)) GTEST_SKIP() << pictures << " is not there";

  // Steps and codes along x, then along y.
  fs::create_directory(path("frames"));
  int next = 0;
  for (const auto& [first, last] :
       {std::pair(0, 17), std::pair(36, 49), std::pair(18, 35), std::pair(50, 61)}) {
    for (int i = first; i <= last; ++i) {
      fs::create_symlink(pictures / fmt::format("im_{:02}.png", i),
                         path("frames") / fmt::format("frame_{:02}.png", next++));
    }
  }
  write_scanner(path("scanner.yaml"), scanner_of_masks());

  const ProgramRun run = run_program({"calibrate",
                                      "residual",
                                      path("frames"),
                                      "--strategy",
                                      "gray-phase",
                                      "--steps",
                                      "18",
                                      "--period-pixels",
                                      "18",
                                      "--reference",
                                      "inverse",
                                      "--no-complementary",
                                      "--origin",
                                      "0.34906585",
                                      "--backwards",
                                      "--axis",
                                      "both",
                                      "--projector",
                                      "1280x800",
                                      "--scanner",
                                      path("scanner.yaml"),
                                      "-o",
                                      path("mapped.yaml")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NEAR(held_out(run.out, "no map"), 0.0235, 0.002) << run.out;
  EXPECT_GT(held_out_by_map(run.out), 0);
  EXPECT_LE(held_out_by_map(run.out), 0.012) << run.out;
}

}  // namespace slipstream::calibrate_residual_program_test
