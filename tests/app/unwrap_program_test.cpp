// Runs `slipstream unwrap`.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/image_file.h"
#include "tests/app/program.h"
#include "tests/spatial/known_phase.h"

namespace slipstream::unwrap_program_test {

class UnwrapProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  [[nodiscard]] static nlohmann::json told(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "unwrap");
    arguments.emplace_back("--json");
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.exit_code == 0 ? nlohmann::json::parse(run.out) : nlohmann::json();
  }

  const KnownPhase known_ = known_phase({80, 60}, 0.02, [](double x, double y) {
    return std::abs(x - 50) < 1 ? std::numeric_limits<double>::quiet_NaN() : 0.5 * x - 0.2 * y;
  });

 private:
  TemporaryFolder folder_;
};

TEST_F(UnwrapProgram, UnwrapsAndAnchors) {
  write_map(path("wrapped.npy"), known_.wrapped);
  write_map(path("wrapped.tiff"), known_.wrapped);
  write_map(path("truth.tiff"), known_.truth);
  const nlohmann::json document =
      told({path("wrapped.npy"), "-o", path("phase.npy"), "--regions", path("regions.tiff"),
            "--preview", path("phase.png"), "--coarse", path("truth.tiff")});
  ASSERT_EQ(document["regions"].size(), 2U);
  EXPECT_EQ(document["regions"][0]["pixels"], 60 * 50);
  EXPECT_EQ(document["regions"][1]["anchored"], true);
  EXPECT_TRUE(std::filesystem::exists(path("phase.png")));
  EXPECT_EQ(read_map(path("regions.tiff"))(70, 5), 2);
  const Image<double> phase = read_map(path("phase.npy"));
  for (const int column : {3, 70}) EXPECT_NEAR(phase(column, 9), known_.truth(column, 9), 1e-4);
  EXPECT_TRUE(std::isnan(phase(50, 9)));

  Image<std::uint8_t> mask({80, 60}, 255);
  std::fill_n(mask.begin(), 80, std::uint8_t{0});
  write_image(path("mask.png"), mask);
  const nlohmann::json masked =
      told({path("wrapped.tiff"), "-o", path("phase.tiff"), "--mask", path("mask.png"), "--quality",
            path("mask.png"), "--anchor", "30", "60", "31.5"});
  EXPECT_EQ(masked["pixels"], 59 * 79);
  EXPECT_EQ(masked["regions"][0]["anchored"], false);
  EXPECT_EQ(masked["regions"][1]["anchored"], true);
  EXPECT_LT(std::abs(read_map(path("phase.tiff"))(60, 30) - 31.5), 3.2);
}

TEST_F(UnwrapProgram, RefusesWhatIsWrong) {
  write_map(path("wrapped.tiff"), known_.wrapped);
  write_map(path("small.tiff"), Image<float>({8, 6}));
  write_image(path("grey.png"), Image<std::uint8_t>({80, 60}));
  const auto refused = [&](std::vector<std::string> arguments, const std::string& part) {
    arguments.insert(arguments.begin(), "unwrap");
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 2) << part;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(path("phase.tiff")));
  };
  const std::string wrapped = path("wrapped.tiff"), phase = path("phase.tiff");
  refused({path("grey.png"), "-o", phase}, "not a map");
  refused({wrapped, "-o", path("phase.png")}, ".npy");
  refused({wrapped, "-o", phase, "--method", "flod"}, "did you mean flood");
  refused({wrapped, "-o", phase, "--mask", path("small.tiff")}, "80x60");
  refused({wrapped, "-o", phase, "--quality", path("small.tiff")}, "80x60");
  refused({wrapped, "-o", phase, "--coarse", path("small.tiff")}, "80x60");
  refused({wrapped, "-o", phase, "--anchor", "60", "0", "1"}, "row 60");
  refused({wrapped, "-o", phase, "--anchor", "1.5", "0", "1"}, "integers");
  refused({wrapped, "-o", phase, "--anchor", "1", "1", "1", "--coarse", wrapped}, "excludes");
}

}  // namespace slipstream::unwrap_program_test
