// Maps without a scanner, and clouds of other programs' maps.
#include <cmath>
#include <numbers>
#include <regex>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "io/image_file.h"
#include "tests/app/program.h"

namespace slipstream::map_program_test {
namespace fs = std::filesystem;

using Words = std::vector<std::string>;

/// Two depth maps of one scan.
struct ComparedDepths {
  int points = 0;  ///< of the first map
  int other = 0;   ///< pixels with a point in one map alone, or over 0.01 mm apart
};

ComparedDepths compared(const Image<double>& depth, const Image<double>& again) {
  ComparedDepths result;
  for (std::size_t i = 0; i < depth.pixel_count(); ++i) {
    const double a = depth.begin()[i], b = again.begin()[i];
    result.points += std::isnan(a) ? 0 : 1;
    result.other += std::isnan(a) != std::isnan(b) || std::abs(a - b) > 0.01 ? 1 : 0;
  }
  return result;
}

class MapProgram : public testing::TestWithParam<Words> {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  [[nodiscard]] static ProgramRun run(Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }
  void simulate(const Words& more) const {
    const ProgramRun made =
        run({"simulate", path("scan"), "--camera", "96x72", "--world", "ideal"}, more);
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  void forget_scanner() const {
    const std::string scan = path("scan/scan.yaml");
    write_file(scan, std::regex_replace(contents(scan), std::regex("scanner:[^\n]*"), ""));
  }
  [[nodiscard]] ProgramRun reconstruct(const Words& more) const {
    return run({"reconstruct", path("scan")}, more);
  }
  void expect_refused(const ProgramRun& run, const std::string& part) const {
    EXPECT_EQ(run.exit_code, 2) << part;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err << "\nlacks: " << part;
    EXPECT_FALSE(fs::exists(path("no.tiff")));
  }

 private:
  TemporaryFolder folder_;
};

class MapProgramMapsAlone : public MapProgram {};

TEST_P(MapProgramMapsAlone, AreThoseThatTheScannerGives) {
  simulate(GetParam());
  const auto maps = [&](const std::string& name) {
    Words words{"--json"};
    for (const std::string map : {"phase", "modulation", "mean", "coordinate"}) {
      words.insert(words.end(), {"--" + map, path(name + map + ".tiff")});
    }
    return reconstruct(words);
  };
  ASSERT_EQ(maps("with-").exit_code, 0);
  forget_scanner();
  const ProgramRun alone = maps("alone-");
  ASSERT_EQ(alone.exit_code, 0) << alone.err;
  EXPECT_EQ(nlohmann::json::parse(alone.out)["scans"][0]["points"], 0);
  for (const char* const map : {"phase", "modulation", "mean", "coordinate"}) {
    EXPECT_EQ(contents(path(fmt::format("with-{}.tiff", map))),
              contents(path(fmt::format("alone-{}.tiff", map))))
        << map;
  }
  expect_refused(reconstruct({"--phase", path("no.tiff"), "-o", path("cloud.ply")}), "no scanner");

  // A preview shows the maps, and without outputs the pixels are counted.
  EXPECT_EQ(reconstruct({"--preview", path("preview.png")}).exit_code, 0);
  EXPECT_TRUE(fs::exists(path("preview.png")));
  const ProgramRun counted = reconstruct({});
  EXPECT_EQ(counted.exit_code, 0) << counted.err;
  EXPECT_NE(counted.out.find("measured "), std::string::npos) << counted.out;
  EXPECT_NE(counted.out.find("no scanner is known"), std::string::npos) << counted.out;
}

INSTANTIATE_TEST_SUITE_P(Scans, MapProgramMapsAlone,
                         testing::Values(Words{"--strategy", "dual-frequency"},
                                         Words{"--strategy", "gray-phase", "--scene", "statue"},
                                         Words{"--strategy", "pcmp", "--axis", "y"}));

class MapProgramWrappedPhase : public MapProgram {};

TEST_P(MapProgramWrappedPhase, NeedsNeitherScannerNorFringeOrder) {
  simulate(GetParam());
  const auto phase = [&](const std::string& name) {
    return reconstruct({"--phase", path(name), "--modulation", path("modulation.tiff")});
  };
  ASSERT_EQ(phase("with.tiff").exit_code, 0);
  expect_refused(reconstruct({"--coordinate", path("no.tiff")}), "no depth");
  forget_scanner();
  ASSERT_EQ(phase("alone.tiff").exit_code, 0);
  EXPECT_EQ(contents(path("with.tiff")), contents(path("alone.tiff")));
  expect_refused(reconstruct({"--coordinate", path("no.tiff")}), "only a wrapped phase");

  const Image<double> wrapped = read_map(path("alone.tiff")),
                      modulation = read_map(path("modulation.tiff")),
                      truth = read_map(path("scan/truth/coordinate.tiff"));
  int lit = 0, wrong = 0;
  for (std::size_t i = 0; i < truth.pixel_count(); ++i) {
    if (!(modulation.begin()[i] > 40) || std::isnan(truth.begin()[i])) continue;
    ++lit;
    const double error = wrapped.begin()[i] - 32 * std::numbers::pi * truth.begin()[i];
    wrong += std::abs(std::remainder(error, 2 * std::numbers::pi)) > 0.3 ? 1 : 0;
  }
  EXPECT_GT(lit, 700);
  EXPECT_LT(wrong, lit / 20);
}

INSTANTIATE_TEST_SUITE_P(
    Scans, MapProgramWrappedPhase,
    testing::Values(Words{"--strategy", "pmp", "--steps", "3", "--frequency", "16"},
                    Words{"--strategy", "pmp", "--steps", "5", "--frequency", "16", "--axis", "y"},
                    Words{"--strategy", "double-three-step", "--frequency", "16"}));

class MapProgramCloudOfMap : public MapProgram {
 protected:
  [[nodiscard]] ProgramRun from(const std::string& form, const std::string& map,
                                const Words& more) const {
    return run({"reconstruct", path(map), "--from", form, "--scanner", path("scan/scanner.yaml")},
               more);
  }
  void write_scaled(const std::string& name, double scale, double shift = 0) const {
    Image<double> map = read_map(path("coordinate.tiff"));
    for (double& value : map) value = scale * value + shift;
    write_map(path(name), map);
  }
};

TEST_P(MapProgramCloudOfMap, IsThatOfItsScan) {
  simulate(GetParam());
  // Cleaning compares modulations, which the map has not.
  ASSERT_EQ(
      reconstruct({"--raw", "--depth", path("depth.tiff"), "--coordinate", path("coordinate.tiff")})
          .exit_code,
      0);
  const bool along_y = GetParam().back() == "y";
  write_scaled("pixels.npy", along_y ? 800 : 1280);
  write_scaled("phase.tiff", 32 * std::numbers::pi);
  const Image<double> depth = read_map(path("depth.tiff"));
  for (const auto& [form, map] : {std::pair("coordinate", "coordinate.tiff"),
                                  {"pixels", "pixels.npy"},
                                  {"phase:16", "phase.tiff"}}) {
    const ProgramRun made =
        from(form, map, {"--raw", "--depth", path("again.tiff"), "--axis", along_y ? "y" : "x"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    EXPECT_EQ(made.err, "");
    const Image<double> again = read_map(path("again.tiff"));
    const auto [points, other] = compared(depth, again);
    EXPECT_GT(points, 1000);
    EXPECT_EQ(other, 0) << form;
  }
}

TEST_P(MapProgramCloudOfMap, IsCleanedByItsModulation) {
  simulate(GetParam());
  ASSERT_EQ(reconstruct({"--raw", "--coordinate", path("coordinate.tiff"), "--modulation",
                         path("modulation.tiff")})
                .exit_code,
            0);
  for (const char* const least : {"15", "40"}) {
    ASSERT_EQ(reconstruct({"--minimum-modulation", least, "--depth", path("depth.tiff")}).exit_code,
              0);
    const ProgramRun made =
        from("coordinate", "coordinate.tiff",
             {"--from-modulation", path("modulation.tiff"), "--minimum-modulation", least,
              "--depth", path("again.tiff"), "--axis", GetParam().back() == "y" ? "y" : "x"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const Image<double> depth = read_map(path("depth.tiff")), again = read_map(path("again.tiff"));
    const auto [points, other] = compared(depth, again);
    EXPECT_GT(points, 500);
    EXPECT_EQ(other, 0) << least;
  }
}

INSTANTIATE_TEST_SUITE_P(Scans, MapProgramCloudOfMap,
                         testing::Values(Words{"--scene", "sphere"}, Words{"--scene", "statue"},
                                         Words{"--scene", "sphere", "--axis", "y"}));

class MapProgramRefusedMap : public MapProgramCloudOfMap {};

TEST_P(MapProgramRefusedMap, IsOneThatCannotBe) {
  simulate(GetParam());
  ASSERT_EQ(reconstruct({"--coordinate", path("coordinate.tiff"), "--phase", path("wrapped.tiff")})
                .exit_code,
            0);
  write_scaled("pixels.tiff", 1280);
  write_map(path("empty.tiff"), Image<float>({96, 72}, std::nanf("")));
  write_map(path("small.tiff"), Image<float>({2, 1}, 0.5F));
  const Words no{"--depth", path("no.tiff")};
  expect_refused(from("coordinate", "pixels.tiff", no), "exceed the projector, 0 to 1");
  expect_refused(from("pixels", "coordinate.tiff", no), "one projector pixel");
  expect_refused(from("phase:4", "pixels.tiff", no), "exceed the projector");
  expect_refused(from("phase:16", "wrapped.tiff", no), "slipstream unwrap");
  expect_refused(from("coordinate", "empty.tiff", no), "no valid value");
  expect_refused(from("coordinate", "small.tiff", no), "96x72");
  for (const char* const form : {"depth", "phase", "phase:", "phase:0", "phase:x", "phase:-3"}) {
    expect_refused(from(form, "coordinate.tiff", no), "phase:PERIODS");
  }
  const std::string map = path("coordinate.tiff");
  expect_refused(run_program({"reconstruct", map, "--from", "coordinate", "--depth", no[1]}),
                 "--scanner");
  expect_refused(from("coordinate", "coordinate.tiff", {"--mean", no[1]}), "--mean");
  expect_refused(from("coordinate", "coordinate.tiff", {"--minimum-modulation", "9", no[0], no[1]}),
                 "--from-modulation");
  expect_refused(from("coordinate", "coordinate.tiff",
                      {"--from-modulation", path("small.tiff"), no[0], no[1]}),
                 "the modulation is 2x1");
  expect_refused(from("coordinate", "coordinate.tiff", {"--depth", map}), "is an input");
}

INSTANTIATE_TEST_SUITE_P(Scans, MapProgramRefusedMap, testing::Values(Words{}));

/// A map of scale y + shift that is taken for another form.
struct MistakenMap {
  const char* name;
  double scale = 1, shift = 0;
  const char* form = "";
  int exit_code = 2;
};

class MapProgramMistakenMaps : public MapProgramCloudOfMap {
 protected:
  /// Flags that follow a remedy; the form becomes `form`.
  static Words flags_of(const nlohmann::json& remedy, std::string& form) {
    Words flags;
    for (const auto& [name, value] : remedy["settings"].items()) {
      if (name == "from") {
        form = value;
      } else {
        flags.push_back("--" + name);
        if (value != "true") flags.push_back(value);
      }
    }
    return flags;
  }
};

TEST_P(MapProgramMistakenMaps, AreRightOnceTheirRemedyIsFollowed) {
  simulate({});
  ASSERT_EQ(
      reconstruct({"--raw", "--depth", path("depth.tiff"), "--coordinate", path("coordinate.tiff")})
          .exit_code,
      0);
  const Image<double> depth = read_map(path("depth.tiff"));

  constexpr double turn = 2 * std::numbers::pi;
  for (const MistakenMap& map : {MistakenMap{"from -pi", 16 * turn, -turn / 2, "phase:16", 0},
                                 {"a period high", 16 * turn, turn, "phase:16"},
                                 {"other periods", 16 * turn, 0, "phase:8"},
                                 {"pixels", 1280, 0, "phase:16"},
                                 {"falling", -1280, 1279, "pixels"}}) {
    // 1. The program warns, or refuses the map.
    write_scaled("map.npy", map.scale, map.shift);
    const ProgramRun told = from(map.form, "map.npy", {"--raw", "--json"});
    ASSERT_EQ(told.exit_code, map.exit_code) << map.name << told.err;
    EXPECT_NE(told.err, "") << map.name;

    const auto document = nlohmann::json::parse(told.out);
    const nlohmann::json& findings =
        map.exit_code == 0 ? document["scans"][0]["findings"] : document["findings"];
    ASSERT_EQ(findings.size(), 1U) << map.name << told.out;

    // 2. With the first remedy the depths are right.
    std::string form = map.form;
    Words flags = flags_of(findings[0]["remedies"][0], form);
    flags.insert(flags.end(), {"--raw", "--depth", path("again.tiff")});
    const ProgramRun made = from(form, "map.npy", flags);
    ASSERT_EQ(made.exit_code, 0) << map.name << made.err;
    EXPECT_EQ(made.err, "") << map.name;

    const Image<double> again = read_map(path("again.tiff"));
    const auto [points, other] = compared(depth, again);
    EXPECT_GT(points, 1000);
    EXPECT_LT(other, points / 200) << map.name;
  }
}

TEST_P(MapProgramMistakenMaps, LeaveOutPixelsThatShareAValue) {
  simulate({});
  ASSERT_EQ(reconstruct({"--raw", "--coordinate", path("coordinate.tiff")}).exit_code, 0);
  Image<double> map = read_map(path("coordinate.tiff"));
  for (double& value : map) value = std::isnan(value) ? 0 : 1280 * value;
  write_map(path("map.npy"), map);

  const ProgramRun made = from("pixels", "map.npy", {"--raw", "--json"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_NE(made.err.find("exactly the value 0"), std::string::npos) << made.err;

  const auto scan = nlohmann::json::parse(made.out)["scans"][0];
  ASSERT_EQ(scan["findings"].size(), 1U);
  EXPECT_EQ(scan["findings"][0]["kind"], "shared-map-value");
  EXPECT_GT(scan["counts"]["too dark"], 500);
}

TEST_P(MapProgramMistakenMaps, AreCorrectedForContrastByTheirModulation) {
  const ProgramRun taken =
      run_program({"simulate", path("poses"), "--boards", "1", "--spacing", "15", "--camera",
                   "320x240", "--strategy", "dual-frequency", "--high", "64", "--steps", "8"});
  ASSERT_EQ(taken.exit_code, 0) << taken.err;
  const std::string pose = path("poses/board01/x");

  // 1. From frames: how many pixels is said.
  const ProgramRun plain =
      run_program({"reconstruct", pose, "--raw", "--depth", path("plain.tiff"), "--coordinate",
                   path("coordinate.tiff"), "--modulation", path("modulation.tiff")});
  ASSERT_EQ(plain.exit_code, 0) << plain.err;
  const ProgramRun corrected = run_program({"reconstruct", pose, "--raw", "--correct-contrast",
                                            "--depth", path("corrected.tiff"), "--json"});
  ASSERT_EQ(corrected.exit_code, 0) << corrected.err;
  const auto scan = nlohmann::json::parse(corrected.out)["scans"][0];
  EXPECT_GT(scan["corrected_for_contrast"], 1000);

  // 2. From the map and its modulation: the same depths, but where frames have more reasons.
  const Words map{"reconstruct", path("coordinate.tiff"),    "--from", "coordinate",
                  "--scanner",   path("poses/scanner.yaml"), "--raw",  "--correct-contrast",
                  "--depth",     path("of_map.tiff")};
  const ProgramRun of_map = run(map, {"--from-modulation", path("modulation.tiff")});
  ASSERT_EQ(of_map.exit_code, 0) << of_map.err;
  const auto [points, other] =
      compared(read_map(path("corrected.tiff")), read_map(path("of_map.tiff")));
  EXPECT_GT(compared(read_map(path("plain.tiff")), read_map(path("corrected.tiff"))).other, 1000);
  EXPECT_LT(other, points / 20);

  expect_refused(run(map, {}), "with --from, --correct-contrast needs --from-modulation");
  simulate({});
  forget_scanner();
  expect_refused(reconstruct({"--correct-contrast"}), "--correct-contrast moves points");
}

INSTANTIATE_TEST_SUITE_P(Scans, MapProgramMistakenMaps, testing::Values(Words{}));

}  // namespace slipstream::map_program_test
