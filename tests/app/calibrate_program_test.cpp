// Runs `slipstream calibrate`, on boards from `simulate`.
#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "io/image_file.h"
#include "io/scan_pictures.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/grey_image.h"
#include "tests/io/temporary_folder.h"
#include "tests/shared_data.h"

namespace slipstream::calibrate_program_test {
namespace fs = std::filesystem;

void expect_bad_input(const ProgramRun& run, const std::vector<std::string>& parts) {
  EXPECT_EQ(run.exit_code, 2) << run.err;
  for (const std::string& part : parts) {
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err << "lacks: " << part;
  }
}

/// Poses of a small virtual board, simulated once for all tests.
class CalibrateProgram : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    const ProgramRun run =
        run_program({"simulate", poses(), "--boards", "4", "--corners", "7x5", "--spacing", "22",
                     "--camera", "320x240", "--strategy", "dual-frequency", "--high", "8"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string poses() { return folder_->path() / "poses"; }

  static ProgramRun calibrate(const std::string& in, const fs::path& out,
                              const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"calibrate", "geometry", in,          "-o", out,
                                       "--corners", "7x5",      "--spacing", "22"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }

  /// Copies the poses, for a test to corrupt.
  static std::string copy_to(const TemporaryFolder& folder) {
    const fs::path copy = folder.path() / "copy";
    fs::copy(poses(), copy, fs::copy_options::recursive);
    return copy;
  }

  static inline std::unique_ptr<TemporaryFolder> folder_;
};

TEST_F(CalibrateProgram, GivesAScannerFileAReportAndADocument) {
  const TemporaryFolder out;
  const ProgramRun run = calibrate(poses(), out.path() / "scanner.yaml",
                                   {"--exclude", "board02", "--report", out.path() / "report",
                                    "--compare", poses() + "/scanner.yaml", "--json",
                                    "--camera-distortion", "2", "--projector-distortion", "2"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* part : {"\"rms\"", "\"camera\"", "\"projector\"", "\"stereo\"", "\"poses\"",
                           "\"name\": \"board01\"", "\"used\": true", "\"used\": false",
                           "\"flatness_mm\"", "\"scale_error\"", "\"compared\"", "only 3 poses"}) {
    EXPECT_NE(run.out.find(part), std::string::npos) << part << "\n" << run.out;
  }
  const Scanner found = read_scanner(out.path() / "scanner.yaml");
  const Scanner truth = read_scanner(poses() + "/scanner.yaml");
  EXPECT_NEAR(found.translation.norm(), truth.translation.norm(), 5);
  for (const char* file : {"report.html", "residuals_camera.png", "residuals_projector.png",
                           "scatter_camera.png", "scatter_projector.png"}) {
    EXPECT_TRUE(fs::exists(out.path() / "report" / file)) << file;
  }
}

TEST_F(CalibrateProgram, TakesRecordingsAsItTakesScanFolders) {
  const TemporaryFolder out;
  const fs::path recorded = out.path() / "recorded";
  for (const char* pose : {"board01", "board02", "board03", "board04"}) {
    fs::create_directories(recorded / pose);
    for (const std::string axis : {"x", "y"}) {
      ASSERT_EQ(
          run_program({"record", "--source", "replay:" + (fs::path(poses()) / pose / axis).string(),
                       "-o", recorded / pose / (axis + ".slip")})
              .exit_code,
          0);
    }
  }
  const auto document = [&](const std::string& in, const std::string& command) {
    const std::string scanner = out.path() / "scanner.yaml";
    const std::vector<std::string> more = command == "geometry"
                                              ? std::vector<std::string>{"--camera-distortion",
                                                                         "2",
                                                                         "--projector-distortion",
                                                                         "2",
                                                                         "-o",
                                                                         scanner}
                                              : std::vector<std::string>{"--scanner", scanner};
    std::vector<std::string> arguments{"calibrate", command,     in,   "--corners",
                                       "7x5",       "--spacing", "22", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    // Memory alignment changes sums by about 1e-11.
    return std::regex_replace(run.out, std::regex(R"((\.\d{6})\d+)"), "$1");
  };
  for (const char* command : {"geometry", "verify"}) {
    EXPECT_EQ(document(poses(), command), document(recorded, command)) << command;
  }
  fs::rename(recorded / "board01" / "x.slip", recorded / "board01" / "z.slip");
  fs::rename(recorded / "board01" / "y.slip", recorded / "board01" / "x.slip");
  fs::rename(recorded / "board01" / "z.slip", recorded / "board01" / "y.slip");
  expect_bad_input(calibrate(recorded, out.path() / "none.yaml", {}), {"x.slip", "axis y"});
}

TEST_F(CalibrateProgram, TakesPosesInOrderAndNoReportForAPose) {
  const TemporaryFolder folder;
  const fs::path copy = copy_to(folder);
  fs::rename(copy / "board01", copy / "board10");
  fs::create_directory(copy / "a report");
  std::ofstream(copy / "a report" / "report.html") << "figures";
  const ProgramRun run = calibrate(copy, folder.path() / "scanner.yaml",
                                   {"--camera-distortion", "2", "--projector-distortion", "2"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LT(run.out.find("board04"), run.out.find("board10")) << run.out;
  EXPECT_EQ(run.out.find("a report"), std::string::npos) << run.out;
}

TEST_F(CalibrateProgram, BadInputIsToldInOneLineAndNothingIsWritten) {
  const TemporaryFolder out;
  const fs::path file = out.path() / "scanner.yaml";
  expect_bad_input(run_program({"calibrate", "geometry", poses(), "-o", file, "--corners", "9x7",
                                "--spacing", "22"}),
                   {"0 of 4 poses", "no chessboard of 9x7 corners"});
  expect_bad_input(calibrate(poses(), file, {"--exclude", "board9"}), {"board9", "no such pose"});
  expect_bad_input(calibrate(poses(), file, {"--exclude", "board01", "--exclude", "board02"}),
                   {"2 of 4 poses", "at least 3"});
  expect_bad_input(calibrate(poses(), file, {"--camera-distortion", "3"}),
                   {"--camera-distortion '3'", "auto"});
  expect_bad_input(calibrate(poses(), file, {"--board", "hexagons"}), {"hexagons"});
  expect_bad_input(calibrate(poses(), file, {"--print", "so-so"}), {"--print so-so"});
  expect_bad_input(calibrate(poses() + "/nowhere", file, {}), {"nowhere", "no such folder"});
  expect_bad_input(calibrate(poses(), file, {"--compare", "nowhere.xml"}), {"nowhere.xml"});
  expect_bad_input(calibrate(poses(), file, {"--minimum-modulation", "256"}),
                   {"board01", "least modulation 256"});
  expect_bad_input(calibrate(poses(), file, {"--neighbourhood", "11"}), {"neighbourhood 11"});
  expect_bad_input(calibrate(poses(), file, {"--beta-p", "300"}), {"beta_p"});
  EXPECT_EQ(entries_in(out.path()), 0);
}

TEST_F(CalibrateProgram, TheScannerToCompareWithMustBeOfTheseDevices) {
  const TemporaryFolder folder;
  Scanner other = read_scanner(poses() + "/scanner.yaml");
  other.camera.size = {640, 480};
  write_scanner(folder.path() / "other.yaml", other);
  expect_bad_input(calibrate(poses(), folder.path() / "scanner.yaml",
                             {"--compare", folder.path() / "other.yaml"}),
                   {"other.yaml", "640x480", "320x240"});
  EXPECT_FALSE(fs::exists(folder.path() / "scanner.yaml"));
}

TEST_F(CalibrateProgram, SwappedMirroredAndMixedCapturesAreTold) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "scanner.yaml";
  const std::string copy = copy_to(folder);
  for (const char* pose : {"board01", "board02", "board03", "board04"}) {
    const fs::path both = fs::path(copy) / pose;
    fs::rename(both / "x", both / "was_x");
    fs::rename(both / "y", both / "x");
    fs::rename(both / "was_x", both / "y");
  }
  expect_bad_input(calibrate(copy, file, {}), {"board01", "axis"});
  for (const char* pose : {"board01", "board02", "board03", "board04"}) {
    for (const char* axis : {"x", "y"}) fs::remove(fs::path(copy) / pose / axis / "scan.yaml");
  }
  const std::vector<std::string> flags{"--strategy", "dual-frequency", "--steps", "3", "--high",
                                       "8",          "--projector",    "1280x800"};
  expect_bad_input(calibrate(copy, file, flags), {"board01", "swapped"});

  const TemporaryFolder other;
  const std::string mixed = copy_to(other);
  const fs::path scan = fs::path(mixed) / "board03" / "x";
  for (const fs::path& frame : images_in_folder(scan)) {
    write_image(frame, Image<std::uint8_t>({160, 120}, 80));
  }
  expect_bad_input(calibrate(mixed, file, {}), {"board03", "160x120", "320x240"});
  EXPECT_FALSE(fs::exists(file));
}

TEST_F(CalibrateProgram, MirroredPicturesAreTold) {
  const TemporaryFolder folder;
  const std::string copy = copy_to(folder);
  for (const auto& entry : fs::recursive_directory_iterator(copy)) {
    if (!is_image_file(entry.path())) continue;
    const Image<std::uint16_t> seen = read_grey_image(entry.path());
    Image<std::uint8_t> mirrored(seen.size());
    for (int row = 0; row < seen.height(); ++row) {
      for (int column = 0; column < seen.width(); ++column) {
        mirrored(seen.width() - 1 - column, row) = static_cast<std::uint8_t>(seen(column, row));
      }
    }
    write_image(entry.path(), mirrored);
  }
  expect_bad_input(calibrate(copy, folder.path() / "scanner.yaml", {}), {"board01", "mirrored"});
  EXPECT_FALSE(fs::exists(folder.path() / "scanner.yaml"));
}

TEST_F(CalibrateProgram, FramesInTheWrongOrderAndAPrintOfTheWrongSizeAreToldByTheirCause) {
  const TemporaryFolder folder;
  const std::string copy = copy_to(folder);
  const fs::path scan = fs::path(copy) / "board02" / "x";
  const std::vector<fs::path> frames = images_in_folder(scan);
  const Image<std::uint16_t> first = read_grey_image(frames[0]);
  for (std::size_t n = 0; n < frames.size(); ++n) {
    const Image<std::uint16_t> next =
        n + 1 < frames.size() ? read_grey_image(frames[n + 1]) : first;
    Image<std::uint8_t> late(next.size());
    std::copy(next.begin(), next.end(), late.begin());
    write_image(frames[n], late);
  }
  const fs::path file = folder.path() / "scanner.yaml";
  const ProgramRun run =
      calibrate(copy, file,
                {"--json", "--measured", "134.1x89.4", "--report", folder.path() / "report",
                 "--camera-distortion", "2", "--projector-distortion", "2"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* part : {"\"findings\"", "\"evidence\"", "board02 along x",
                           "the frames have slipped: the cycle begins at frame 5",
                           "the order 5,0,1,2,3,4 corrects this", "wrong scale",
                           "use --spacing 22.35", "\"try\"", "\"depths_mm\""}) {
    EXPECT_NE(run.out.find(part), std::string::npos) << part << "\n" << run.out;
  }
  EXPECT_NE(run.err.find("likely the frames have slipped"), std::string::npos) << run.err;
  std::ifstream report(folder.path() / "report" / "report.html");
  const std::string text{std::istreambuf_iterator<char>(report), {}};
  EXPECT_NE(text.find("the frames have slipped"), std::string::npos) << text;
  const std::optional<DepthRange> depths = read_scanner(file).calibrated_depths;
  ASSERT_TRUE(depths);
  EXPECT_GT(depths->nearest, 350);
  EXPECT_LT(depths->farthest, 900);
  expect_bad_input(calibrate(copy, file, {"--measured", "134"}), {"--measured 134", "two lengths"});
  expect_bad_input(calibrate(copy, file, {"--measured", "so x long"}), {"--measured"});
}

TEST_F(CalibrateProgram, VerifiesAScannerAndCorrectsIt) {
  const TemporaryFolder folder;
  const std::string truth = poses() + "/scanner.yaml", old = folder.path() / "old.yaml";
  const std::string corrected = folder.path() / "corrected.yaml";
  const auto verify = [&](const std::string& in, const std::string& scanner) {
    return run_program({"calibrate", "verify", in, "--scanner", scanner, "--corners", "7x5",
                        "--spacing", "22", "-o", corrected});
  };
  const ProgramRun good = verify(poses(), truth);
  ASSERT_EQ(good.exit_code, 0) << good.err;
  EXPECT_NE(good.out.find("scanner.yaml holds"), std::string::npos) << good.out;
  EXPECT_FALSE(fs::exists(corrected)) << "there was nothing to correct";

  Scanner knocked = read_scanner(truth);
  knocked.rotation = Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX()) * knocked.rotation;
  write_scanner(old, knocked);
  const ProgramRun bad = verify(poses() + "/board01", old);
  ASSERT_EQ(bad.exit_code, 0) << bad.err;
  EXPECT_NE(bad.out.find("is wrong; the corrected pose is right"), std::string::npos) << bad.out;
  EXPECT_NE(bad.err.find("moved relative to each other"), std::string::npos) << bad.err;
  const Scanner found = read_scanner(corrected);
  EXPECT_LT(Eigen::AngleAxisd(found.rotation.transpose() * read_scanner(truth).rotation).angle(),
            0.003);
  EXPECT_EQ(found.camera, knocked.camera);
  EXPECT_NE(found.measured.find("pose corrected by 1 boards"), std::string::npos);

  knocked.camera.intrinsic(0, 0) *= 1.1;
  knocked.camera.intrinsic(1, 1) *= 1.1;
  write_scanner(old, knocked);
  fs::remove(corrected);
  expect_bad_input(verify(poses(), old), {"was not written", "focus, zoom", "calibrate geometry"});
  EXPECT_FALSE(fs::exists(corrected));
}

TEST_F(CalibrateProgram, VerifyTakesTheProjectorSizeFromTheScannerFile) {
  const TemporaryFolder folder;
  const fs::path copy = copy_to(folder);
  const auto verify = [&](const fs::path& scanner, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{
        "calibrate", "verify", copy,         "--scanner",      scanner,  "--corners", "7x5",
        "--spacing", "22",     "--strategy", "dual-frequency", "--high", "8"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  };
  Scanner scanner = read_scanner(copy / "scanner.yaml");
  scanner.projector.size.width += 2;
  write_scanner(folder.path() / "wider.yaml", scanner);
  expect_bad_input(verify(folder.path() / "wider.yaml", {}),  // the scans give their own size
                   {"the projector has", "both must match"});
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(copy)) {
    if (entry.path().filename() == "scan.yaml") fs::remove(entry.path());
  }
  const ProgramRun run = verify(copy / "scanner.yaml", {});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("scanner.yaml holds"), std::string::npos) << run.out;
  write_file(folder.path() / "sizeless.yaml",
             std::regex_replace(read_text(copy / "scanner.yaml"),
                                std::regex("projector_(width|height): \\d+\n"), ""));
  expect_bad_input(verify(folder.path() / "sizeless.yaml", {}), {"--projector"});
}

// Square fringes: 16 periods across the columns, 10 down the rows.
TEST(CalibrateProgramLengths, InProjectorPixelsGiveTheFocalLengthsOfBothAxes) {
  const fs::path folder = shared_cases() / "01-period-pixels-along-y";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const TemporaryFolder out;
  const fs::path file = out.path() / "out.yaml";
  const ProgramRun run =
      run_program({"calibrate", "geometry", folder / "poses", "--corners", "9x6", "--spacing", "20",
                   "--strategy", "multi-frequency", "--period-pixels", "1280,80", "--steps", "4",
                   "--projector", "1280x800", "-o", file});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Scanner read = read_scanner(file), truth = read_scanner(folder / "truth-scanner.yaml");
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(read.projector.intrinsic(i, i) / truth.projector.intrinsic(i, i), 1, 0.005);
    EXPECT_NEAR(read.camera.intrinsic(i, i) / truth.camera.intrinsic(i, i), 1, 0.005);
  }
}

TEST(CalibrateProgramBoard, DrawsABoardAndSaysHowLargeToPrintIt) {
  const TemporaryFolder out;
  const fs::path file = out.path() / "board.png";
  const ProgramRun run = run_program(
      {"calibrate", "board", "-o", file, "--corners", "9x6", "--spacing", "20", "--dpi", "254"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("240.00 mm x 180.00 mm"), std::string::npos) << run.out;
  EXPECT_EQ(read_grey_image(file).size(), (Size{2400, 1800}));
  const auto picture = read_file(file);  // 10,000 pixels per metre
  EXPECT_EQ(std::string(picture.begin() + 33, picture.begin() + 50),
            std::string("\0\0\0\x09pHYs\0\0\x27\x10\0\0\x27\x10\x01", 17));
  for (const char* ending : {"svg", "pdf"}) {
    const fs::path print = out.path() / fmt::format("board.{}", ending);
    ASSERT_EQ(run_program({"calibrate", "board", "-o", print, "--corners", "9x6", "--spacing", "20",
                           "--dpi", "254"})
                  .exit_code,
              0);
    const auto bytes = read_file(print);
    const std::string text(bytes.begin(), bytes.end());
    const bool svg = print.extension() == ".svg";
    // A square of 20 mm, the ruler, and the page: the board and a strip of 12 mm.
    EXPECT_NE(text.find(svg ? "h20.0000v20.0000" : "20.0000 20.0000 re"), std::string::npos);
    EXPECT_NE(text.find(svg ? ">100 mm<" : "(100 mm) Tj"), std::string::npos);
    EXPECT_NE(text.find(svg ? "240.0000mm\" height=\"192.0000mm" : "[0 0 680.3150 544.2520]"),
              std::string::npos);
  }
  expect_bad_input(
      run_program({"calibrate", "board", "-o", file, "--corners", "9", "--spacing", "20"}),
      {"--corners '9'", "13x9"});
  expect_bad_input(run_program({"calibrate", "board", "-o", file, "--spacing", "20", "--dpi", "0"}),
                   {"--dpi 0"});
  expect_bad_input(run_program({"calibrate", "board", "-o", file}),
                   {"--spacing is missing", "measure the side of a square"});
}

TEST(CalibrateProgramSimulatedBoards, RefusesTheFlagsOfAScene) {
  const TemporaryFolder out;
  const std::string folder = out.path() / "boards";
  for (const std::vector<std::string>& flag :
       std::vector<std::vector<std::string>>{{"--scene", "sphere"},
                                             {"--axis", "y"},
                                             {"--move", "1", "0", "0"},
                                             {"--colour"},
                                             {"--primaries"}}) {
    std::vector<std::string> arguments{"simulate", folder, "--boards", "2", "--spacing", "10"};
    arguments.insert(arguments.end(), flag.begin(), flag.end());
    expect_bad_input(run_program(arguments), {"--boards", flag[0]});
  }
  expect_bad_input(run_program({"simulate", folder, "--corners", "9x6"}), {"--boards"});
  expect_bad_input(run_program({"simulate", folder, "--boards", "0", "--spacing", "10"}),
                   {"--boards 0"});
  expect_bad_input(run_program({"simulate", folder, "--boards", "2", "--spacing", "60"}),
                   {"does not fit"});
  EXPECT_FALSE(fs::exists(folder));
}

/// Points that were saved give the scanner of the frames, within its standard deviations.
TEST_F(CalibrateProgram, CalibratesFromSavedPoints) {
  const TemporaryFolder out;
  const fs::path points = out.path() / "points.csv", again = out.path() / "again.yaml";
  ProgramRun run =
      calibrate(poses(), out.path() / "scanner.yaml", {"--save-points", points, "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto of_frames = nlohmann::json::parse(run.out);

  run = run_program({"calibrate", "points", points, "--camera", "320x240", "--projector",
                     "1280x800", "-o", again, "--report", out.path() / "report", "--compare",
                     out.path() / "scanner.yaml", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto of_points = nlohmann::json::parse(run.out);
  EXPECT_TRUE(fs::exists(out.path() / "report" / "report.html"));
  EXPECT_EQ(of_points["poses"].size(), of_frames["poses"].size());

  const Scanner first = read_scanner(out.path() / "scanner.yaml"), second = read_scanner(again);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(first.translation[axis], second.translation[axis],
                of_frames["translation_deviation_mm"][axis].get<double>());
  }
  EXPECT_NEAR(first.camera.intrinsic(0, 0), second.camera.intrinsic(0, 0),
              of_frames["camera"]["focal_deviation_px"][0].get<double>());

  run = run_program({"calibrate", "points", points, "--camera", "320x240", "--projector", "640x400",
                     "-o", out.path() / "none.yaml"});
  expect_bad_input(run, {"projector lie outside its picture of 640x400"});
  EXPECT_FALSE(fs::exists(out.path() / "none.yaml"));
}

}  // namespace slipstream::calibrate_program_test
