// Runs every strategy through patterns, simulate, reconstruct and live; also errors for invalid
// settings.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "io/image_file.h"
#include "slipstream/strategy.h"
#include "tests/app/program.h"
#include "tests/io/grey_image.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::strategies_program_test {

std::vector<std::string> every_name() {
  std::vector<std::string> names;
  for (const std::string_view name : strategy_names()) names.emplace_back(name);
  return names;
}

std::string without_hyphens(std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

class StrategiesProgram : public testing::TestWithParam<std::string> {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  /// Decoded from one frame by windows: inexact at edges, reliable only on large surfaces.
  [[nodiscard]] bool of_one_frame() const { return make_strategy(GetParam(), {}).is_spectral(); }

  /// Adds a little noise: without it, frames of equal patterns count as duplicates.
  void simulate() const {
    const ProgramRun run = run_program(
        {"simulate", path("scan"), "--strategy", GetParam(), "--world", "ideal", "--scene",
         of_one_frame() ? "board" : "sphere", "--camera", of_one_frame() ? "320x240" : "160x120",
         "--virtual-noise", "0.01", "--camera-bits", "16"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

 private:
  TemporaryFolder folder_;
};

TEST_P(StrategiesProgram, ReconstructsWhatItSimulates) {
  simulate();
  std::vector<std::string> reconstruct = {"reconstruct",  path("scan"),
                                          "--depth",      path("depth.tiff"),
                                          "--coordinate", path("coordinate.tiff")};
  if (GetParam() == "fourier") {
    reconstruct.insert(reconstruct.end(), {"--nearest", "495", "--farthest", "761"});
  }
  const ProgramRun run = run_program(reconstruct);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  const Strategy strategy = make_strategy(GetParam(), {});
  const auto& code = strategy.layout().code;
  const bool code_alone = code && GetParam() != "gray-phase";
  const std::string what = code_alone ? "coordinate.tiff" : "depth.tiff";
  const Image<double> made = read_map(path(what)), depth = read_map(path("depth.tiff")),
                      truth = read_map(path("scan/truth/" + what));
  const double bound =
      code_alone ? 1 / code->stripes : std::max(0.5, 2.5 / highest_frequency(strategy));  // mm
  int points = 0, far = 0;
  for (std::size_t i = 0; i < made.pixel_count(); ++i) {
    if (std::isnan(depth.begin()[i])) continue;
    ++points;
    far += std::abs(made.begin()[i] - truth.begin()[i]) > bound ? 1 : 0;
  }
  EXPECT_GT(points, 5000);
  EXPECT_LE(far, of_one_frame() ? points / 10 : 0);
}

INSTANTIATE_TEST_SUITE_P(Registry, StrategiesProgram, testing::ValuesIn(every_name()),
                         [](const auto& info) { return without_hyphens(info.param); });

class StrategiesProgramLive : public StrategiesProgram {};

TEST_P(StrategiesProgramLive, HasTheCloudOfTheScan) {
  simulate();
  ASSERT_EQ(run_program({"reconstruct", path("scan"), "-o", path("cloud.ply")}).exit_code, 0);
  const ProgramRun live = run_program({"live", "--source", "replay:" + path("scan"), "--rate", "0",
                                       "--headless", "-o", path("live.ply")});
  ASSERT_EQ(live.exit_code, 0) << live.err;
  EXPECT_TRUE(contents(path("live.ply")) == contents(path("cloud.ply")));
  if (!of_one_frame()) return;
  const ProgramRun record = run_program(
      {"record", "--source", "replay:" + path("scan"), "--rate", "0", "-o", path("scan.slip")});
  EXPECT_EQ(record.exit_code, 2) << record.err;
  EXPECT_NE(record.err.find("written as captured"), std::string::npos) << record.err;
  EXPECT_FALSE(std::filesystem::exists(path("scan.slip")));
}

INSTANTIATE_TEST_SUITE_P(Registry, StrategiesProgramLive,
                         testing::Values("multi-frequency", "gray-phase", "micro", "modulated",
                                         "de-bruijn", "m-array"),
                         [](const auto& info) { return without_hyphens(info.param); });

class StrategiesProgramRefused : public StrategiesProgram {
 protected:
  void expect_line(const std::vector<std::string>& arguments, const std::string& part) const {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err << "lacks: " << part;
  }
};

TEST_P(StrategiesProgramRefused, WithWhatWouldBeRight) {
  const auto patterns = [&](const std::string& strategy, std::vector<std::string> settings) {
    settings.insert(settings.begin(), {"patterns", path("new"), "--strategy", strategy});
    return settings;
  };
  expect_line(patterns("gray-phase", {"--bits", "3", "--periods", "32"}), "which require 5");
  expect_line(patterns("multi-frequency", {"--periods", "12,16", "--unwrapping", "number-theory"}),
              "no common multiple");
  expect_line(patterns("multi-frequency", {"--steps", "3,3", "--periods", "1,6,36"}),
              "one for all, or one for each");
  expect_line(patterns("multi-frequency", {"--periods", "4,16", "--unwrapping", "hierarchical"}),
              "at most 1 period");
  expect_line(patterns("micro", {"--periods", "64,32"}), "no common multiple");
  expect_line(patterns("gray", {"--bits", "12", "--projector", "1920x1080"}), "at most 1920");
  expect_line(patterns("pcps", {"--steps", "5"}), "even");
  expect_line(patterns("modulated", {"--carrier-steps", "1"}), "2 to 16");
  expect_line(patterns("modulated", {"--carrier", "0"}), "carrier");
  expect_line(patterns("modulated", {"--periods", "4,16"}), "at most 1 period");
  expect_line(patterns("modulated", {"--projector", "1024x100"}), "at most 50");
  expect_line(patterns("modulated", {"--axis", "both", "--carrier", "600"}), "at most 540");

  simulate();
  expect_line({"reconstruct", path("scan"), "--strategy", "gray-phase"},
              "9 frames, but gray-phase has 10 (4 steps + 6 bits): likely a frame is missing; or "
              "try --steps 3 or --no-complementary");
  std::filesystem::remove(path("scan/scan.yaml"));
  expect_line({"reconstruct", path("scan"), "--strategy", "micro", "--period-pixels", "16,15,14"},
              "--projector");
}

INSTANTIATE_TEST_SUITE_P(Registry, StrategiesProgramRefused, testing::Values("multi-frequency"),
                         [](const auto& info) { return without_hyphens(info.param); });

/// Number of measured coordinates, and of those that differ by more than `bound` from the scan's
/// truth.
std::pair<int, int> points_and_far(const std::string& file, const std::string& scan, double bound) {
  const Image<double> found = read_map(file), truth = read_map(scan + "/truth/coordinate.tiff");
  int points = 0, far = 0;
  for (std::size_t i = 0; i < found.pixel_count(); ++i) {
    if (std::isnan(found.begin()[i]) || std::isnan(truth.begin()[i])) continue;
    ++points;
    far += std::abs(found.begin()[i] - truth.begin()[i]) > bound ? 1 : 0;
  }
  return {points, far};
}

class StrategiesProgramShifts : public StrategiesProgramRefused {};

TEST_P(StrategiesProgramShifts, ShowsAndReadsAnyShifts) {
  const std::string shifts = "0,45,120,200,310";
  const auto run = [&](std::vector<std::string> arguments, std::vector<std::string> more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  };
  const std::vector<std::string> told{"--strategy", GetParam(), "--shifts", shifts};
  // Patterns are rounded to 8 bits: 1.6e-3 of a period.
  const double bound = 1.6e-3 / highest_frequency(make_strategy(GetParam(), {}));
  ASSERT_EQ(run({"patterns", path("patterns"), "--projector", "640x480"}, told).exit_code, 0);
  const Image<std::uint16_t> second = read_grey_image(path("patterns/pattern_01.png"));
  EXPECT_NEAR(second(0, 0), 255 * (0.5 + 0.5 * std::sqrt(0.5)), 0.51);
  for (const char* const gamma : {"1", "1.6"}) {
    ASSERT_EQ(
        run({"simulate", path("scan"), "--world", "ideal", "--scene", "sphere", "--camera",
             "160x120", "--virtual-noise", "0.01", "--camera-bits", "16", "--virtual-gamma", gamma},
            told)
            .exit_code,
        0);
    EXPECT_NE(contents(path("scan/scan.yaml")).find(shifts), std::string::npos);
    for (const char* const backend : {"fused", "equation"}) {
      const ProgramRun made =
          run_program({"reconstruct", path("scan"), "--gamma", gamma, "--backend", backend, "--raw",
                       "--coordinate", path("coordinate.tiff")});
      ASSERT_EQ(made.exit_code, 0) << made.err;
      EXPECT_EQ(made.err, "");
      const auto [points, far] = points_and_far(path("coordinate.tiff"), path("scan"), bound);
      EXPECT_GT(points, 5000);
      EXPECT_LE(far, points / 500) << gamma << ' ' << backend;
    }
  }
  expect_line({"patterns", path("new"), "--strategy", GetParam(), "--shifts", "0,90"}, "2 steps");
  expect_line({"patterns", path("new"), "--strategy", GetParam(), "--shifts", "0,180,360"},
              "at least 3 must differ");
  expect_line(
      {"patterns", path("new"), "--strategy", GetParam(), "--shifts", "0,90,180", "--steps", "3"},
      "with shifts has no setting 'steps'");
  expect_line({"patterns", path("new"), "--strategy", "micro", "--shifts", "0,90,180"},
              "micro has no setting 'shifts'");
  // Either on the command line replaces the other of the scan.
  EXPECT_EQ(run_program({"reconstruct", path("scan"), "--steps", "5", "--coordinate",
                         path("coordinate.tiff"), "--anyway"})
                .exit_code,
            0);
}

INSTANTIATE_TEST_SUITE_P(Registry, StrategiesProgramShifts,
                         testing::Values("pmp", "dual-frequency", "multi-frequency", "gray-phase"),
                         [](const auto& info) { return without_hyphens(info.param); });

class StrategiesProgramMicro : public StrategiesProgramRefused {};

TEST_P(StrategiesProgramMicro, ReadsFramesOfAlternatingSign) {
  std::vector<std::string> words{"simulate",      path("scan"),  "--strategy", GetParam(),
                                 "--alternating", "--backwards", "--scene",    "sphere",
                                 "--camera",      "160x120",     "--periods",  "25,23,22,19"};
  ASSERT_EQ(run_program(words).exit_code, 0);
  EXPECT_EQ(run_program({"check", path("scan")}).exit_code, 0);
  ASSERT_EQ(
      run_program({"reconstruct", path("scan"), "--raw", "--coordinate", path("coordinate.tiff")})
          .exit_code,
      0);
  const auto [points, far] = points_and_far(path("coordinate.tiff"), path("scan"), 0.002);
  EXPECT_GT(points, 5000);
  EXPECT_LE(far, points / 100);
  // Read otherwise, the check names the settings.
  const ProgramRun other = run_program({"check", path("scan"), "--no-alternating"});
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_NE(other.out.find("try --alternating"), std::string::npos) << other.out;
  const ProgramRun both =
      run_program({"check", path("scan"), "--no-alternating", "--no-backwards"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_NE(both.out.find("try --alternating --backwards"), std::string::npos) << both.out;
}

INSTANTIATE_TEST_SUITE_P(Registry, StrategiesProgramMicro, testing::Values("micro"));

/// A setting given in two spellings, across the field and in projector pixels.
struct TwoSpellings {
  std::string strategy;
  std::vector<std::string> one, other;
};

TEST(StrategiesProgramTwoSpellings, OfOneSettingAreRefused) {
  const TemporaryFolder folder;
  const std::string rig = folder.path() / "rig.yaml";

  for (const auto& [strategy, one, other] :
       {TwoSpellings{"gray", {"--stripes", "300"}, {"--stripe", "2"}},
        TwoSpellings{"multi-frequency", {"--periods", "1,16"}, {"--period-pixels", "640,40"}},
        TwoSpellings{"pmp", {"--frequency", "16"}, {"--period-pixels", "40"}},
        TwoSpellings{"dual-frequency", {"--high", "16"}, {"--period-pixels", "40"}},
        TwoSpellings{"dual-frequency", {"--low", "2"}, {"--period-pixels", "320,40"}}}) {
    SCOPED_TRACE(testing::PrintToString(one));
    std::vector<std::string> words{"patterns", folder.path() / "out", "--strategy",
                                   strategy,   "--projector",         "640x480"};
    const auto with = [&](std::vector<std::string> more) {
      more.insert(more.begin(), words.begin(), words.end());
      return run_program(more);
    };

    const ProgramRun both = with({one[0], one[1], other[0], other[1]});
    EXPECT_EQ(both.exit_code, 2) << both.out;
    EXPECT_EQ(std::count(both.err.begin(), both.err.end(), '\n'), 1) << both.err;
    for (const std::string& flag : {one[0], other[0]}) {
      EXPECT_TRUE(std::regex_search(both.err, std::regex(flag + "[; ]"))) << both.err;
    }

    // In a rig file, too, unless the command line gives one of them.
    const auto line_of = [](const std::vector<std::string>& setting) {
      return setting[0].substr(2) + ": '" + setting[1] + "'\n";
    };
    write_file(rig, line_of(one) + line_of(other));
    const ProgramRun in_file = with({"--rig", rig});
    EXPECT_EQ(in_file.exit_code, 2) << in_file.out;
    EXPECT_NE(in_file.err.find("rig.yaml: line "), std::string::npos) << in_file.err;

    if (one[0] == "--low") continue;  // replaces only one of two periods: refused here too
    write_file(rig, line_of(other));
    const ProgramRun overridden = with({one[0], one[1], "--rig", rig});
    EXPECT_EQ(overridden.exit_code, 0) << overridden.err;
    const std::string said = contents(folder.path() / "out" / "scan.yaml");
    EXPECT_NE(said.find(one[1]), std::string::npos) << said;
  }
}

/// Former names are the same flags; each is refused beside its present one.
TEST(StrategiesProgramTwoSpellings, OfAFlagAreOneFlag) {
  for (const auto& [now, former] : std::vector<std::pair<std::string, std::string>>{
           {"--minimum-modulation", "--min-modulation"},
           {"--smallest-component", "--min-component"},
           {"--largest-sigma", "--max-sigma"},
           {"--widest-gap", "--fill"},
           {"--smoothing", "--smooth"},
           {"--ambient-light", "--ambient"}}) {
    const ProgramRun run = run_program({"reconstruct", "scan", now, "1", former, "2"});
    EXPECT_EQ(run.exit_code, 2) << now;
    EXPECT_NE(run.err.find(now), std::string::npos) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
}

TEST(StrategiesProgramStripesInPixels, AreOfThatWidthAlongBothAxes) {
  const TemporaryFolder folder;
  const ProgramRun run = run_program({"patterns", folder.path() / "out", "--strategy", "gray",
                                      "--bits", "10", "--stripe", "2", "--reference", "none",
                                      "--axis", "both", "--projector", "640x480"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const bool along_y : {false, true}) {
    const Image<std::uint16_t> finest =
        read_grey_image(folder.path() / "out" / (along_y ? "pattern_19.png" : "pattern_09.png"));
    const int length = along_y ? finest.height() : finest.width();
    for (int n = 0; n < length; n += 2) {
      const auto level = [&](int i) { return along_y ? finest(5, i) : finest(i, 5); };
      EXPECT_EQ(level(n), level(n + 1)) << n;
      if (n % 4 == 2 && n + 2 < length) EXPECT_EQ(level(n), level(n + 2)) << n;
      if (n % 4 == 0) EXPECT_NE(level(n), level(n + 2)) << n;
    }
  }
}

}  // namespace slipstream::strategies_program_test
