// Runs the program: normal use, and every kind of bad input.
#include "tests/app/program.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/mount.h>

#include "io/file.h"
#include "io/image_file.h"
#include "slipstream/scanner_file.h"
#include "tests/io/grey_image.h"
#include "tests/io/temporary_folder.h"
#include "tests/shared_data.h"

namespace slipstream::program_test {
namespace fs = std::filesystem;

/// A small virtual scan in scan/, one copy per test.
class Program : public testing::Test {
 protected:
  void SetUp() override { copy_simulated_scan({"--camera", "96x72"}, path("scan")); }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  /// Reconstructs scan/ to cloud.ply.
  [[nodiscard]] ProgramRun reconstruct(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"reconstruct", path("scan"), "-o", path("cloud.ply")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }

  /// Expects this exit code, one line on stderr with all `parts`, and no output.
  void expect_refused(const ProgramRun& run, int exit_code, const std::vector<std::string>& parts) {
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_EQ(run.out, "");
    for (const std::string& part : parts) {
      EXPECT_NE(run.err.find(part), std::string::npos) << run.err << "lacks: " << part;
    }
    EXPECT_FALSE(fs::exists(path("cloud.ply")));
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path())) {
      EXPECT_NE(entry.path().extension(), ".part") << entry.path();
    }
  }

  void replace_in(const std::string& file, const std::string& text, const std::string& by) const {
    std::string whole = contents(path(file));
    const std::size_t at = whole.find(text);
    ASSERT_NE(at, std::string::npos) << file << " has no " << text;
    write_file(path(file), whole.replace(at, text.size(), by));
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(Program, TurnsAScanIntoEverythingAskedFor) {
  const ProgramRun run =
      reconstruct({"--depth", path("depth.tiff"), "--coordinate", path("coordinate.tiff"),
                   "--modulation", path("B.tiff"), "--phase", path("phase.tiff"), "--mean",
                   path("A.tiff"), "--preview", path("preview.png"), "--normals"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_NE(run.out.find("RMS error against truth"), std::string::npos);
  EXPECT_EQ(read_map(path("depth.tiff")).size(), (Size{96, 72}));
  for (const char* name :
       {"cloud.ply", "coordinate.tiff", "B.tiff", "phase.tiff", "A.tiff", "preview.png"}) {
    EXPECT_TRUE(fs::exists(path(name))) << name;
  }
}

TEST_F(Program, PrintsOneJsonDocument) {
  const ProgramRun run = reconstruct({"--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out.front(), '{');
  EXPECT_NE(run.out.find("\"rms_mm\""), std::string::npos);
  EXPECT_NE(run.err.find("points of"), std::string::npos);
}

TEST_F(Program, TakesABareFolderAndFlags) {
  fs::create_directory(path("bare"));
  for (int n = 0; n < 6; ++n) {
    const std::string name = "frame_0" + std::to_string(n) + ".png";
    fs::copy(path("scan/") + name, path("bare/") + name);
  }
  const ProgramRun run = run_program({"reconstruct",
                                      path("bare"),
                                      "--strategy",
                                      "dual-frequency",
                                      "--steps",
                                      "3",
                                      "--high",
                                      "16",
                                      "--low",
                                      "1",
                                      "--axis",
                                      "x",
                                      "--projector",
                                      "1280x800",
                                      "--scanner",
                                      path("scan/scanner.yaml"),
                                      "--minimum-modulation",
                                      "15",
                                      "-o",
                                      path("cloud.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  ASSERT_EQ(run_program({"reconstruct", path("scan"), "-o", path("same.ply")}).exit_code, 0);
  EXPECT_EQ(contents(path("cloud.ply")), contents(path("same.ply")));
}

TEST_F(Program, BackendsGiveTheSameCloud) {
  for (const std::string backend : {"lut", "equation", "closed-form", "fused"}) {
    const ProgramRun run = run_program(
        {"reconstruct", path("scan"), "--backend", backend, "--depth", path(backend + ".tiff")});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const std::string name = backend == "lut" ? "reference (lut)" : backend;
    EXPECT_NE(run.out.find("backend " + name), std::string::npos) << run.out;
  }
  const Image<double> lut = read_map(path("lut.tiff"));
  for (const char* other : {"equation.tiff", "closed-form.tiff", "fused.tiff"}) {
    const Image<double> map = read_map(path(other));
    for (std::size_t i = 0; i < map.pixel_count(); ++i) {
      ASSERT_EQ(std::isnan(map.begin()[i]), std::isnan(lut.begin()[i]));
      if (!std::isnan(map.begin()[i])) ASSERT_NEAR(map.begin()[i], lut.begin()[i], 1e-3);
    }
  }
}

TEST_F(Program, SaysThatTheEquationsDecodeFiveSteps) {
  ASSERT_EQ(run_program({"simulate", path("five"), "--camera", "96x72", "--strategy", "pmp",
                         "--steps", "5"})
                .exit_code,
            0);
  const ProgramRun run = run_program({"reconstruct", path("five"), "--backend", "lut"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("backend equation"), std::string::npos) << run.out;
}

TEST_F(Program, MultiplexesTheCueIntoTheSameFrames) {
  for (const char* const steps : {"3", "4", "5"}) {
    ASSERT_EQ(run_program({"simulate", path("pcmp"), "--camera", "160x120", "--scene", "board",
                           "--strategy", "pcmp", "--steps", steps, "--alpha-p", "200", "--beta-p",
                           "40", "--virtual-ambient", "-4"})
                  .exit_code,
              0);
    for (const char* const rule : {"published", "likelihood", "consensus"}) {
      const ProgramRun run = run_program({"reconstruct", path("pcmp"), "--cue-rule", rule,
                                          "--ambient-light", "-4", "-o", path("pcmp.ply")});
      EXPECT_EQ(run.exit_code, 0) << run.err;
      EXPECT_NE(run.out.find("RMS error"), std::string::npos) << run.out;
    }
  }
  expect_refused(run_program({"reconstruct", path("pcmp"), "--cue-rule", "spatial"}), 2,
                 {"spatial", "consensus"});
  expect_refused(
      run_program({"simulate", path("x"), "--strategy", "pcmp", "--high", "4", "--share", "0.2"}),
      2, {"share", "0.25"});
}

TEST_F(Program, TakesSeveralScans) {
  fs::copy(path("scan"), path("other"), fs::copy_options::recursive);
  const ProgramRun run =
      run_program({"reconstruct", path("scan"), path("other"), "-o", path("{name}.ply")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(fs::exists(path("scan.ply")) && fs::exists(path("other.ply")));
  expect_refused(run_program({"reconstruct", path("scan"), path("other"), "-o", path("cloud.ply")}),
                 2, {"cloud.ply", "{name}"});
}

TEST_F(Program, ManyScansAreAsOneByOneAndGoOnPastOneThatFails) {
  const std::vector<std::string> names{"scan", "b", "c", "d", "e"};
  std::vector<std::string> scans;
  for (const std::string& name : names) {
    if (name != "scan") {
      ASSERT_EQ(
          run_program({"simulate", path(name), "--camera", "96x72", "--scene", "sphere"}).exit_code,
          0);
    }
    scans.push_back(path(name));
  }
  fs::remove(path("c/frame_02.png"));
  std::vector<std::string> arguments{"reconstruct", "-o", path("{name}.ply")};
  arguments.insert(arguments.end(), scans.begin(), scans.end());
  const ProgramRun many = run_program(arguments);
  EXPECT_EQ(many.exit_code, 2);
  EXPECT_NE(many.err.find("frame_02.png"), std::string::npos) << many.err;
  std::size_t told = 0;
  for (const std::string& name : names) {
    EXPECT_EQ(fs::exists(path(name + ".ply")), name != "c") << name;
    if (name == "c") continue;
    EXPECT_EQ(run_program({"reconstruct", path(name), "-o", path("alone.ply")}).exit_code, 0);
    EXPECT_EQ(contents(path("alone.ply")), contents(path(name + ".ply"))) << name;
    const std::size_t at = many.out.find(path(name) + ": ");
    EXPECT_GE(at, told) << "in the order given";
    told = at;
  }
}

TEST_F(Program, WritesPatterns) {
  const ProgramRun run =
      run_program({"patterns", path("patterns"), "--strategy", "pmp", "--steps", "4", "--projector",
                   "64x48", "--axis", "y", "--pattern-bits", "10"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Image<std::uint16_t> pattern = read_grey_image(path("patterns/pattern_00.png"));
  EXPECT_EQ(pattern.size(), (Size{64, 48}));
  EXPECT_EQ(pattern(5, 0), 1023);
  EXPECT_EQ(pattern(5, 24), 0);
  EXPECT_EQ(entries_in(path("patterns")), 5);
}

TEST_F(Program, WritesOnePictureOfAllPatterns) {
  const ProgramRun run =
      run_program({"patterns", path("patterns"), "--strategy", "gray", "--bits", "3", "--projector",
                   "48x64", "--axis", "y", "--sheet", path("sheet.png"), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Image<std::uint16_t> sheet = read_grey_image(path("sheet.png"));
  EXPECT_EQ(sheet.size(), (Size{64, 5 * 20 - 4}));
  EXPECT_EQ(sheet(0, 0), 0) << "the widest stripes first, from left to right";
  EXPECT_EQ(sheet(63, 15), 255);
  EXPECT_EQ(sheet(0, 16), 255) << "between two";
  EXPECT_NE(run.out.find("sheet.png"), std::string::npos);
  EXPECT_EQ(run_program({"patterns", path("new"), "--sheet", "sheet.jpg"}).exit_code, 2);
  EXPECT_FALSE(fs::exists(path("new")));
}

TEST_F(Program, WritesPatternsOfOneBit) {
  const ProgramRun run = run_program({"patterns", path("patterns"), "--binary", "--strategy", "pmp",
                                      "--steps", "4", "--projector", "64x48"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string file = contents(path("patterns/pattern_01.png"));
  EXPECT_EQ(file.at(24), 1) << "bits of a pixel, as a PNG file says them";
  EXPECT_EQ(file.at(25), 0) << "grey";
  const Image<std::uint16_t> pattern = read_grey_image(path("patterns/pattern_01.png"));
  for (const std::uint16_t level : pattern) EXPECT_TRUE(level == 0 || level == 255) << level;
}

TEST_F(Program, SimulatesPatternsOfOneBit) {
  const ProgramRun run = run_program({"simulate", path("binary"), "--binary", "--scene", "sphere",
                                      "--world", "bench", "--camera", "160x120"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(contents(path("binary/scan.yaml")).find("binary: true"), std::string::npos);
  const ProgramRun cloud =
      run_program({"reconstruct", path("binary"), "-o", path("cloud.ply"), "--json"});
  ASSERT_EQ(cloud.exit_code, 0) << cloud.err;
  const nlohmann::json scan = nlohmann::json::parse(cloud.out)["scans"][0];
  EXPECT_GT(scan["points"], 4000);
  EXPECT_LT(scan["rms_mm"], 2);
}

TEST_F(Program, TakesBothAxesInOneScan) {
  for (const char* const exposures : {"1", "1,4"}) {
    ASSERT_EQ(run_program({"simulate", path("both"), "--axis", "both", "--exposures", exposures,
                           "--camera", "96x72"})
                  .exit_code,
              0);
    EXPECT_NE(contents(path("both/scan.yaml")).find("axis: both"), std::string::npos);
    const ProgramRun run =
        run_program({"reconstruct", path("both"), "--epipolar", path("epipolar.tiff"), "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const nlohmann::json scan = nlohmann::json::parse(run.out)["scans"][0];
    EXPECT_LT(scan["epipolar"]["median_length_px"], scan["epipolar"]["median_sigma_px"]);
    EXPECT_EQ(scan["findings"].size(), 0U) << run.out;
    EXPECT_GT(scan["points"], 1000);
    EXPECT_EQ(read_map(path("epipolar.tiff")).size(), (Size{96, 72}));
    EXPECT_EQ(run_program({"check", path("both")}).exit_code, 0);
  }
  expect_refused(reconstruct({"--epipolar", path("epipolar.tiff")}), 2, {"--axis both"});
}

TEST_F(Program, TakesTheFringeOrderFromARangeOfDepth) {
  ASSERT_EQ(run_program({"simulate", path("fine"), "--scene", "board", "--strategy", "pmp",
                         "--frequency", "8", "--camera", "96x72"})
                .exit_code,
            0);
  const auto at = [&](const char* farthest) {
    return run_program({"reconstruct", path("fine"), "--nearest", "560", "--farthest", farthest,
                        "-o", path("cloud.ply")});
  };
  expect_refused(run_program({"reconstruct", path("fine"), "-o", path("cloud.ply")}), 2,
                 {"--nearest", "--farthest"});
  expect_refused(at("2000"), 2, {"from 560 to", "periods"});
  const ProgramRun run = at("640");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("RMS error"), std::string::npos) << run.out;
  EXPECT_EQ(run_program({"check", path("fine")}).exit_code, 0);
}

TEST_F(Program, ADashIsStandardOutput) {
  const std::string scan = path("scan"), cloud = path("cloud.ply");
  ASSERT_EQ(run_program({"reconstruct", scan, "-o", cloud}).exit_code, 0);
  const ProgramRun run = run_program({"reconstruct", scan, "-o", "-"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, contents(cloud));
  EXPECT_NE(run.err.find("points of"), std::string::npos) << run.err;
  const ProgramRun both = run_program({"reconstruct", scan, "-o", "-", "--json"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_NE(both.err.find("standard output"), std::string::npos) << both.err;
  const ProgramRun two = run_program({"reconstruct", scan, scan, "-o", "-"});
  EXPECT_EQ(two.exit_code, 2) << two.err;
}

TEST_F(Program, ShowsWhatItDoes) {
  const ProgramRun run = run_program({"demo", path("demo"), "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_GT(nlohmann::json::parse(run.out)["points"], 100000);
  for (const char* const file : {"scan/scan.yaml", "cloud.ply", "depth.tiff", "preview.png"}) {
    EXPECT_TRUE(fs::exists(path("demo") + "/" + file)) << file;
  }
  // It ends with a command that works where it was called.
  const std::string next = std::string(SLIPSTREAM_PROGRAM) + " reconstruct " + path("demo/scan");
  EXPECT_NE(run.err.find(next), std::string::npos) << run.err;
}

TEST_F(Program, AShorterScanLeavesNoFrameOfTheOneBefore) {
  fs::copy(path("scan/frame_00.png"), path("scan/frame_mine.png"));
  const ProgramRun run = run_program(
      {"simulate", path("scan"), "--camera", "96x72", "--strategy", "pmp", "--steps", "3"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("replacing its scan"), std::string::npos) << run.out;
  EXPECT_TRUE(fs::exists(path("scan/frame_02.png")) && fs::exists(path("scan/frame_mine.png")));
  EXPECT_FALSE(fs::exists(path("scan/frame_03.png")) || fs::exists(path("scan/frame_05.png")));
}

TEST_F(Program, FewerPatternsLeaveNoneOfThoseBefore) {
  const auto write = [&](const char* steps) {
    return run_program({"patterns", path("patterns"), "--projector", "64x48", "--strategy", "pmp",
                        "--steps", steps});
  };
  EXPECT_EQ(write("6").out.find("replacing"), std::string::npos);
  EXPECT_NE(write("3").out.find("replacing its scan"), std::string::npos);
  EXPECT_TRUE(fs::exists(path("patterns/pattern_02.png")));
  EXPECT_FALSE(fs::exists(path("patterns/pattern_03.png")));
}

TEST_F(Program, MissingFrame) {
  fs::remove(path("scan/frame_03.png"));
  expect_refused(reconstruct(), 2, {"frame_03.png", "no such file"});
}

TEST_F(Program, FramesThatAreNotOfTheCamera) {
  const std::string other = path("other");
  ASSERT_EQ(run_program({"simulate", other, "--camera", "64x48"}).exit_code, 0);
  expect_refused(reconstruct({"--scanner", other + "/scanner.yaml"}), 2,
                 {"scanner.yaml", "64x48", "96x72"});
}

TEST_F(Program, ValueOutOfRangeInScanYaml) {
  replace_in("scan/scan.yaml", "high: 16", "high: -16");
  expect_refused(reconstruct(), 2, {"scan.yaml", "-16", "positive"});
}

TEST_F(Program, ScannerWithNan) {
  std::string whole = contents(path("scan/scanner.yaml"));
  const std::size_t translation = whole.find("translation");
  const std::size_t data = whole.find("data: [", translation) + 7;
  write_file(path("scan/scanner.yaml"),
             whole.substr(0, data) + " .Nan" + whole.substr(whole.find(',', data)));
  expect_refused(reconstruct(), 2, {"scanner.yaml", "translation", "finite"});
}

TEST_F(Program, ZeroBaseline) {
  Scanner scanner = read_scanner(path("scan/scanner.yaml"));
  scanner.translation.setZero();
  write_scanner(path("scan/scanner.yaml"), scanner);
  expect_refused(reconstruct(), 2, {"scanner.yaml", "baseline 0 mm"});
}

TEST_F(Program, ScannerThatSeesNoDepthAlongThisAxis) {
  Scanner scanner = read_scanner(path("scan/scanner.yaml"));
  scanner.rotation.setIdentity();
  scanner.translation = {0, 100, 0};
  write_scanner(path("scan/scanner.yaml"), scanner);
  expect_refused(reconstruct(), 2, {"axis x", "use axis y"});
}

TEST_F(Program, UnwritableOutput) {
  expect_refused(run_program({"reconstruct", path("scan"), "-o", path("missing/cloud.ply")}), 1,
                 {"missing/cloud.ply"});
  expect_refused(run_program({"reconstruct", path("scan"), "-o", path("cloud.las")}), 2,
                 {"cloud.las", ".ply"});
  expect_refused(run_program({"reconstruct", path("scan"), "--depth", path("depth.png")}), 2,
                 {"depth.png", ".tiff"});
  expect_refused(run_program({"simulate", path("scan/scan.yaml")}), 1, {"scan.yaml"});
}

TEST_F(Program, FileTooLargeForTheDisk) {
  const ProgramRun run =
      run_program({"reconstruct", path("scan"), "-o", path("cloud.ply")}, 16 * 1024);
  expect_refused(run, 1, {"cloud.ply", "File too large"});
}

TEST_F(Program, FullDisk) {
  const std::string disk = path("disk");
  fs::create_directory(disk);
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=32k") != 0) {
    GTEST_SKIP() << "a small tmpfs needs root and the right to mount";
  }
  const ProgramRun cloud = run_program({"reconstruct", path("scan"), "-o", disk + "/cloud.ply"});
  const int left_of_cloud = entries_in(disk);
  const ProgramRun scan = run_program({"simulate", disk + "/scan", "--camera", "320x240"});
  const bool described = fs::exists(disk + "/scan/scan.yaml");
  ::umount(disk.c_str());
  expect_refused(cloud, 1, {"cloud.ply", "No space left"});
  EXPECT_EQ(left_of_cloud, 0);
  expect_refused(scan, 1, {"No space left"});
  EXPECT_FALSE(described);
}

TEST_F(Program, ColourFrameIsConvertedWithAWarning) {
  // A PPM file with the extension .png.
  const Image<std::uint16_t> grey = read_grey_image(path("scan/frame_00.png"));
  std::string ppm = "P6\n96 72\n255\n";
  for (const std::uint16_t pixel : grey) ppm.append(3, static_cast<char>(pixel));
  write_file(path("scan/frame_00.png"), ppm);
  const ProgramRun run = reconstruct();
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_NE(run.err.find("warning: " + path("scan/frame_00.png")), std::string::npos) << run.err;
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
}

TEST_F(Program, BadFlags) {
  const std::vector<std::vector<std::string>> bad{
      {"reconstruct"},
      {"reconstruct", path("nowhere")},
      {"reconstruct", path("scan/scan.yaml")},
      {"reconstruct", path("scan"), "--backend", "cuda"},
      {"reconstruct", path("scan"), "--minimum-modulation", "many"},
      {"reconstruct", path("scan"), "--minimum-modulation", "nan"},
      {"reconstruct", path("scan"), "--projector", "1824"},
      {"reconstruct", path("scan"), "--projector", "1824x1140"},
      {"reconstruct", path("scan"), "--strategy", "gray-code"},
      {"reconstruct", path("scan"), "--frequency", "2"},
      {"reconstruct", path("scan"), "--camera-bits", "99"},
      {"reconstruct", path("scan"), "--camera-bits", "12"},
      {"reconstruct", path("scan"), "--threads", "-1"},
      {"simulate", path("new"), "--scene", "teapot"},
      {"simulate", path("new"), "--mesh", path("scan/scan.yaml")},
      {"simulate", path("new"), "--camera-bits", "7"},
      {"simulate", path("new"), "--virtual-noise", "-1"},
      {"simulate", path("new"), "--reflectivity", "2"},
      {"simulate", path("new"), "--primaries", "--second-camera"},
      {"simulate", path("new"), "--high", "4000"},
      {"simulate", path("new"), "--alpha-p", "300"},
      {"patterns", path("new"), "--steps", "2"},
      {"patterns", path("new"), "--pattern-bits", "4"},
      {"patterns", path("new"), "--uniform", "8", "--pattern-bits", "10"},
      {"patterns", path("new"), "--uniform", "8", "--precompensate", "2.2"},
      {"patterns", path("new"), "--binary", "--pattern-bits", "10"},
      {"patterns", path("new"), "--binary", "--precompensate", "2.2"},
      {"patterns", path("new"), "--binary", "--uniform", "8"},
      {"patterns", path("new"), "--axis", "z"},
      {"patterns", path("new"), "--high", "nan"},
      {"calibrate"},
  };
  for (const auto& arguments : bad) {
    SCOPED_TRACE(testing::PrintToString(arguments));
    expect_refused(run_program(arguments), 2, {"slipstream: "});
    EXPECT_FALSE(fs::exists(path("new")));
  }
}

}  // namespace slipstream::program_test
