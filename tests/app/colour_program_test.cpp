// Runs the program with scans in colour.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "slipstream/cloud_file.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::colour_program_test {

class ColourProgram : public testing::Test {
 protected:
  /// A painted board, three patterns in each picture, and a white picture.
  void SetUp() override {
    copy_simulated_scan({"--colour", "--paint", "0.5", "--scene", "board", "--camera", "160x120",
                         "--strategy", "dual-frequency", "--steps", "3"},
                        path("scan"));
  }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  [[nodiscard]] Cloud cloud_by(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"-o", path("cloud.ply")});
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return read_cloud(path("cloud.ply")).cloud;
  }

 private:
  TemporaryFolder folder_;
};

/// The mean of red, green and blue.
std::array<double, 3> mean_of(const Image<Colour>& colours) {
  std::array<double, 3> mean{};
  const auto count = static_cast<double>(colours.pixel_count());
  for (const auto& [red, green, blue] : colours) {
    mean[0] += red / count;
    mean[1] += green / count;
    mean[2] += blue / count;
  }
  return mean;
}

TEST_F(ColourProgram, WritesCloudsInTheColoursOfTheWhitePicture) {
  const Cloud cloud = cloud_by({"reconstruct", path("scan")});
  ASSERT_FALSE(cloud.colour.empty());

  // Paint of all hues: at some points each channel is the brightest.
  for (const auto channel : {&Colour::red, &Colour::green, &Colour::blue}) {
    EXPECT_TRUE(std::ranges::any_of(cloud.colour, [&](const Colour& of) {
      return of.*channel >= std::max({of.red, of.green, of.blue});
    }));
  }

  // The same through MCAP and PCD.
  for (const std::string name : {"clouds.mcap", "cloud.pcd"}) {
    ASSERT_EQ(run_program({"convert", path("scan"), "-o", path(name)}).exit_code, 0);
    const Cloud other = cloud_by({"convert", path(name)});
    EXPECT_TRUE(std::ranges::equal(other.colour, cloud.colour)) << name;
  }
}

TEST_F(ColourProgram, BalancesWhiteByTheGreyPatchAndKeepsItInTheScannerFile) {
  const std::string patch = "80x60+40+30", scanner = path("scan/scanner.yaml");
  const Cloud asked = cloud_by({"reconstruct", path("scan"), "--grey-patch", patch});

  const ProgramRun run = run_program({"calibrate", "colour", path("scan"), "--grey-patch", patch,
                                      "--scanner", scanner, "-o", scanner, "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto balance = nlohmann::json::parse(run.out)["white_balance"];
  ASSERT_EQ(balance.size(), 3U);
  EXPECT_EQ(read_scanner(scanner).photometry.white_balance.value()[2], balance[2]);

  const Cloud known = cloud_by({"reconstruct", path("scan")});
  EXPECT_TRUE(std::ranges::equal(known.colour, asked.colour));
  const auto [red, green, blue] = mean_of(known.colour);
  EXPECT_NEAR(red, green, 0.05 * green);
  EXPECT_NEAR(blue, green, 0.05 * green);

  const ProgramRun outside =
      run_program({"reconstruct", path("scan"), "--grey-patch", "80x60+140+30"});
  EXPECT_EQ(outside.exit_code, 2);
  EXPECT_NE(outside.err.find("--grey-patch"), std::string::npos) << outside.err;
}

TEST_F(ColourProgram, RefusesAMosaicThatIsNone) {
  const ProgramRun run = run_program({"reconstruct", path("scan"), "--mosaic", "RB"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("--mosaic RB"), std::string::npos) << run.err;
}

}  // namespace slipstream::colour_program_test
