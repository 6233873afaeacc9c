// From calibration to a cloud with commands only, against a virtual scanner served as a camera.
#include <cmath>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "slipstream/recording.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/devices/served_camera.h"
#include "tests/io/temporary_folder.h"
#include "tests/recording/recorded_frames.h"

namespace slipstream::capture_program_test {
namespace fs = std::filesystem;

using Arguments = std::vector<std::string>;

Arguments operator+(Arguments arguments, const Arguments& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

const Arguments patterns{"--strategy", "dual-frequency", "--steps", "4",       "--high",
                         "16",         "--low",          "1",       "--marker"};
const Arguments board{"--corners", "13x9", "--spacing", "15"};

/// The tolerances of a calibration from virtual boards on disk.
void expect_near(const Scanner& found, const Scanner& truth) {
  for (const auto& [lens, true_lens] :
       {std::pair(found.camera, truth.camera), std::pair(found.projector, truth.projector)}) {
    const Eigen::Matrix3d &K = lens.intrinsic, &true_K = true_lens.intrinsic;
    EXPECT_NEAR(K(0, 0), true_K(0, 0), 1e-3 * true_K(0, 0));
    EXPECT_NEAR(K(1, 1), true_K(1, 1), 1e-3 * true_K(1, 1));
    EXPECT_NEAR(K(0, 2), true_K(0, 2), 1);
    EXPECT_NEAR(K(1, 2), true_K(1, 2), 1);
  }
  EXPECT_NEAR(found.translation.norm(), truth.translation.norm(), 1e-3 * truth.translation.norm());
  const Eigen::AngleAxisd turn(found.rotation.transpose() * truth.rotation);
  EXPECT_LT(turn.angle() * 180 / M_PI, 0.02);
}

class CaptureProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string in_folder(const std::string& name) const {
    return folder_.path() / name;
  }
  void expect_runs(const Arguments& arguments, const std::string& words = "") const {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << arguments.front() << ": " << run.err;
    EXPECT_NE((run.out + run.err).find(words), std::string::npos) << run.out << run.err;
  }

  TemporaryFolder folder_;
};

TEST_F(CaptureProgram, LeadsFromNothingToACloud) {
  REQUIRE_CAMERA(slipstream::serve(std::vector<Frame>{some_frame(0)}));
  const std::string poses = in_folder("poses"), scan = in_folder("scan"),
                    scanner = poses + "/scanner.yaml", truth = in_folder("truth.yaml");
  const Arguments camera{"--source", "aravis:127.0.0.1"};
  RunningProgram server(Arguments{"camera", "serve", "--boards", "12", "--rate", "60", "--cycles",
                                  "4", "--write-scanner", truth, "--world", "ideal"} +
                        board + patterns);
  ASSERT_TRUE(server.wait_for_words("serving dual-frequency of 640x480")) << server.words();

  expect_runs(
      Arguments{"capture", "--poses", "12", "--headless", "--projector", "1280x800", "-o", poses} +
          camera + board + patterns,
      "12 of 12: board12 captured");
  expect_near(read_scanner(scanner), read_scanner(truth));
  EXPECT_NE(contents(poses + "/report/report.html").find(">41 degrees Celsius"),
            std::string::npos);
  expect_runs(Arguments{"calibrate", "geometry", poses, "-o", in_folder("again.yaml")} + board);
  EXPECT_EQ(read_scanner(in_folder("again.yaml")).translation, read_scanner(scanner).translation);

  expect_runs(Arguments{"capture", "--scanner", scanner, "-o", scan} + camera + patterns);
  EXPECT_NE(contents(scan + "/scan.yaml").find("Sensor: 41"), std::string::npos);
  expect_runs(Arguments{"calibrate", "verify", "--repeat", "0.01", "--scanner", scanner, "--report",
                        in_folder("warm-up")} +
                  camera + patterns,
              "too few scans");
  EXPECT_NE(contents(in_folder("warm-up/report.html")).find(">41 degrees Celsius"),
            std::string::npos);
  expect_runs({"assist", scan, "--scanner", scanner});
  expect_runs({"check", scan}, "OK: no problems found");
  expect_runs({"reconstruct", scan, "-o", in_folder("cloud.ply")}, "points of 307200");
  EXPECT_GT(fs::file_size(in_folder("cloud.ply")), 1000000U);
  expect_runs(Arguments{"capture", "--scanner", scanner, "-o", in_folder("scan.slip")} + camera +
              patterns);
  EXPECT_EQ(RecordingReader(in_folder("scan.slip")).count(), 8U);
  expect_runs(Arguments{"live", "--indexing", "marker", "--scanner", scanner, "--frames", "60",
                        "--headless", "-o", in_folder("live.ply"), "--strategy", "dual-frequency",
                        "--steps", "4", "--high", "16", "--low", "1"} +
              camera);
  EXPECT_TRUE(fs::exists(in_folder("live.ply")));
  server.send(SIGINT);
  EXPECT_EQ(server.wait(), 0) << server.words();
}

TEST_F(CaptureProgram, ScansTheVirtualScannerAndItsReplay) {
  const Arguments small{"--camera", "96x72", "--scene", "sphere"};
  expect_runs(Arguments{"capture", "--source", "virtual", "-o", in_folder("scan")} + small);
  expect_runs({"reconstruct", in_folder("scan"), "-o", in_folder("cloud.ply")});
  expect_runs(Arguments{"capture", "--source", "virtual", "-o", in_folder("scan.slip")} + small);
  expect_runs({"capture", "--source", "replay:" + in_folder("scan"), "-o", in_folder("again")});
  EXPECT_EQ(contents(in_folder("scan/frame_00.png")), contents(in_folder("again/frame_00.png")));
}

// Two exposures measure 98 % of the lit pixels of this scene, one 52 %.
TEST_F(CaptureProgram, ChoosesItsExposures) {
  const std::string scan = in_folder("scan");
  const ProgramRun run = run_program({"capture", "--source", "virtual", "--world", "ideal",
                                      "--scene", "contrast", "--camera", "160x120", "--strategy",
                                      "pmp", "--steps", "4", "--auto", "60", "-o", scan, "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto document = nlohmann::json::parse(run.out);
  EXPECT_GE(document["automatic"]["exposures"].size(), 2U);
  EXPECT_GE(document["automatic"]["measured"], 0.97);
  EXPECT_EQ(document["frames"], 4 * document["automatic"]["exposures"].size());
  expect_runs({"reconstruct", scan, "-o", in_folder("cloud.ply")});

  for (const Arguments& wrong :
       {Arguments{"--exposures", "1,4"}, Arguments{"--poses"}, Arguments{"--auto", "0.1"}}) {
    const ProgramRun refused = run_program(
        Arguments{"capture", "--source", "virtual", "--auto", "-o", in_folder("no")} + wrong);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_FALSE(fs::exists(in_folder("no")));
  }
}

TEST_F(CaptureProgram, AssistTakesAScanOrASourceThatCanBeSet) {
  const ProgramRun both = run_program({"assist", in_folder("scan"), "--source", "virtual"});
  EXPECT_EQ(both.exit_code, 2) << both.err;
  EXPECT_NE(both.err.find("excludes"), std::string::npos) << both.err;
  const ProgramRun replay = run_program({"assist", "--source", "replay:" + in_folder("scan")});
  EXPECT_EQ(replay.exit_code, 2) << replay.err;
  EXPECT_NE(replay.err.find("recording"), std::string::npos) << replay.err;
}

TEST_F(CaptureProgram, RefusesInOneLine) {
  const auto expect_refused = [&](const Arguments& more, int code, const std::string& named) {
    const ProgramRun run = run_program(Arguments{"capture", "-o", in_folder("out")} + more);
    EXPECT_EQ(run.exit_code, code) << run.err;
    EXPECT_NE(run.err.find(named), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(in_folder("out")));
  };
  expect_refused({"--source", "replay:scan", "--poses", "3"}, 2, "no moving board");
  expect_refused({"--source", "virtual", "--monitor", "0"}, 2, "cannot see a monitor");
  expect_refused({"--source", "v4l2:0", "--poses", "-1"}, 2, "--poses -1");
  expect_refused({"--source", "v4l2:0", "--settle", "-1"}, 2, "--settle -1");
  expect_refused({"--source", "v4l2:0", "--trigger", "Software"}, 2, "--trigger Software");
  expect_refused({"--source", "v4l2:63", "--poses", "--headless"}, 1, "/dev/video63");
  expect_refused(
      {"--source", "virtual", "--camera", "96x72", "--move", "3", "0", "0", "--rate", "200"}, 1,
      "does not stand still");
  fs::create_directory(in_folder("full"));
  fs::create_directory(in_folder("full/scan"));
  const ProgramRun run = run_program({"capture", "--source", "virtual", "-o", in_folder("full")});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("already exists"), std::string::npos) << run.err;
}

TEST_F(CaptureProgram, AnAddressThatNoInterfaceHasIsToldWithWhatToDo) {
  const ProgramRun run = run_program(
      {"camera", "serve", "--camera", "32x24", "--cycles", "1", "--address", "192.0.2.77"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("ip address add 192.0.2.77/24 dev INTERFACE"), std::string::npos)
      << run.err;
}

TEST_F(CaptureProgram, PatternsHaveAMarkerThatIsNoFrame) {
  expect_runs({"patterns", in_folder("patterns"), "--projector", "64x48", "--marker"});
  const ProgramRun without =
      run_program({"patterns", in_folder("plain"), "--projector", "64x48", "--json"});
  const auto count = [&](const std::string& name) {
    std::size_t pictures = 0;
    for (const auto& entry : fs::directory_iterator(in_folder(name))) {
      pictures += entry.path().extension() == ".png" ? 1 : 0;
    }
    return pictures;
  };
  EXPECT_EQ(count("patterns"), count("plain") + 1);
  EXPECT_NE(contents(in_folder("patterns/scan.yaml")).find("marker: true"), std::string::npos);
}

}  // namespace slipstream::capture_program_test
