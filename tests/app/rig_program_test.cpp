// Tests --rig, and errors for unknown words.
#include <filesystem>
#include <fstream>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "io/opencv_storage.h"
#include "io/scan_folder.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::rig_program_test {
namespace fs = std::filesystem;

class RigProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  void write_rig(const std::string& text) const {
    fs::create_directories(path("rig"));
    std::ofstream(path("rig/rig.yaml")) << text;
  }

  [[nodiscard]] ProgramRun run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--rig", path("rig/rig.yaml")});
    return run_program(arguments);
  }

  TemporaryFolder folder_;
};

constexpr const char* small_rig =
    "camera: {camera: 96x72, rate: 0, source: virtual}\n"
    "sequence: {strategy: pmp, steps: 5}\n"
    "filters: {min-modulation: 20, keep-saturated: true}\n"
    "move: [0.1, 0, 0]\n";

TEST_F(RigProgram, SaysWhatTheCommandLineDoesNot) {
  write_rig(small_rig);
  ASSERT_EQ(run({"simulate", path("scan")}).exit_code, 0);
  EXPECT_EQ(frame_count(read_scan_files(path("scan/scan.yaml")).sequence.strategy), 5);
  ASSERT_EQ(run({"simulate", path("six"), "--steps", "6"}).exit_code, 0);
  EXPECT_EQ(frame_count(read_scan_files(path("six/scan.yaml")).sequence.strategy), 6);

  // The file may supply required flags; flags of other commands are ignored.
  const ProgramRun recorded = run({"record", "--frames", "10", "-o", path("scan.slip")});
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  EXPECT_EQ(run({"check", path("scan.slip")}).exit_code, 0);
  EXPECT_EQ(run({"reconstruct", path("scan"), "-o", path("cloud.ply")}).exit_code, 0);
  EXPECT_EQ(run({"bench", "--help"}).exit_code, 0);
}

TEST_F(RigProgram, PathsAreRelativeToTheFile) {
  ASSERT_EQ(run_program({"simulate", path("rig/scan"), "--camera", "96x72", "--strategy", "pmp",
                         "--steps", "4"})
                .exit_code,
            0);
  fs::rename(path("rig/scan/scanner.yaml"), path("rig/scanner.yaml"));
  write_rig("scanner: scanner.yaml\nsource: replay:scan\nstrategy: pmp\nsteps: 4\n");
  const ProgramRun reconstructed = run({"reconstruct", path("rig/scan"), "-o", path("a.ply")});
  EXPECT_EQ(reconstructed.exit_code, 0) << reconstructed.err;
  const ProgramRun live = run({"live", "--headless", "-o", path("b.ply")});
  EXPECT_EQ(live.exit_code, 0) << live.err;

  // The same scanner as the two files of another tool.
  auto entries = read_opencv_storage(path("rig/scanner.yaml"));
  const auto take = [&](const char* name) { return entries.extract(name).mapped(); };
  const std::map<std::string, StoredMatrix> intrinsics{{"M1", take("camera_matrix")},
                                                       {"D1", take("camera_distortion")},
                                                       {"M2", take("projector_matrix")},
                                                       {"D2", take("projector_distortion")}};
  entries["R"] = take("rotation");
  entries["T"] = take("translation");
  write_file(path("rig/intrinsics.yml"), new_storage(intrinsics, false));
  write_file(path("rig/extrinsics.yml"), new_storage(entries, false));
  write_rig("scanner: intrinsics.yml,extrinsics.yml\n");
  const ProgramRun pair = run({"reconstruct", path("rig/scan"), "-o", path("c.ply")});
  EXPECT_EQ(pair.exit_code, 0) << pair.err;
  EXPECT_EQ(read_file(path("c.ply")), read_file(path("a.ply")));
}

TEST_F(RigProgram, WhatTheCommandLineExcludesIsPassedOver) {
  write_rig("scene: sphere\nspacing: 22\ncorners: 7x5\naxis: x\ncamera: 96x72\n");
  const ProgramRun scan = run({"simulate", path("scan")});
  EXPECT_EQ(scan.exit_code, 0) << scan.err;
  const ProgramRun boards = run({"simulate", path("boards"), "--boards", "1"});
  EXPECT_EQ(boards.exit_code, 0) << boards.err;
}

TEST_F(RigProgram, RefusesInOneLine) {
  for (const auto& [text, part] : std::vector<std::pair<std::string, std::string>>{
           {"camera:\n  stratgy: pmp\n",
            "line 2: no command has a setting 'stratgy'; did you mean "
            "strategy?"},
           {"output: cloud.ply\n", "'output'"},
           {"steps: many\n", "line 1"},
           {"motion: [1, 2]\n", "motion"},
           {"keep-saturated: perhaps\n", "keep-saturated"},
           {"max-sigma: 1\nlargest-sigma: 2\n", "line 2: 'largest-sigma' is named twice"},
           {"steps: [\n", "not YAML"}}) {
    SCOPED_TRACE(text);
    write_rig(text);
    const ProgramRun refused = run({"live", "--frames", "4", "--headless"});
    EXPECT_EQ(refused.exit_code, 2) << refused.err;
    EXPECT_NE(refused.err.find("rig.yaml"), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find(part), std::string::npos) << refused.err;
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
  }
}

/// The working folder during a test.
class WorkingFolder {
 public:
  explicit WorkingFolder(const fs::path& folder) { fs::current_path(folder); }
  WorkingFolder(const WorkingFolder&) = delete;
  WorkingFolder& operator=(const WorkingFolder&) = delete;
  ~WorkingFolder() { fs::current_path(before_); }

 private:
  fs::path before_ = fs::current_path();
};

/// A setting of a stranger's rig file, the command that obeys it, and a part of the message.
struct RefusedSetting {
  std::string setting;
  std::vector<std::string> command;
  std::string part;
};

void PrintTo(const RefusedSetting& refused, std::ostream* stream) {
  *stream << refused.setting;
}

/// Works in the folder `rig`, in which are `bashrc`, the text file `text.png` and, beside it, the
/// folder `other`, to which the link `out` leads.
class RigProgramOfStrangers : public RigProgram,
                              public testing::WithParamInterface<RefusedSetting> {
 protected:
  void SetUp() override {
    write_rig("");
    fs::create_directory(path("other"));
    fs::create_directory_symlink(path("other"), path("rig/out"));
    fs::create_symlink(path("other/new.slip"), path("rig/link.slip"));
    for (const char* name : {"rig/bashrc", "rig/text.png", "rig/text.slip", "other/a.png"}) {
      std::ofstream(path(name)) << "precious";
    }
    copy_simulated_scan({"--camera", "64x48"}, path("rig/scan"));
  }
};

TEST_P(RigProgramOfStrangers, WritesNowhereElseAndOverNothingElse) {
  const auto& [setting, command, part] = GetParam();
  write_rig("source: virtual\nworld: ideal\ncamera: 64x48\nrate: 0\nstrategy: pmp\n" + setting +
            "\n");
  const WorkingFolder folder(path("rig"));

  const ProgramRun refused = run(command);
  EXPECT_EQ(refused.exit_code, 2) << refused.err;
  EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
  EXPECT_NE(refused.err.find("rig.yaml: line 6: "), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find(part), std::string::npos) << refused.err;

  for (const char* name : {"rig/bashrc", "rig/text.png", "rig/text.slip", "other/a.png"}) {
    EXPECT_EQ(contents(path(name)), "precious") << name;
  }
  EXPECT_EQ(entries_in(path("other")), 1);
  EXPECT_EQ(entries_in(path("rig")), 7);
}

const std::vector<std::string> live_command{"live", "--frames", "20", "--headless"};
const std::vector<std::string> reconstruct_command{"reconstruct", "scan", "--anyway"};

INSTANTIATE_TEST_SUITE_P(
    Settings, RigProgramOfStrangers,
    testing::Values(
        RefusedSetting{"record: bashrc", live_command, "use .slip"},
        RefusedSetting{"record: new.png", live_command, "use .slip"},
        RefusedSetting{"record: ../new.slip", live_command, "working folder"},
        RefusedSetting{"record: /new.slip", live_command, "working folder"},
        RefusedSetting{"record: out/new.slip", live_command, "working folder"},
        RefusedSetting{"record: link.slip", live_command, "working folder"},
        RefusedSetting{"record: text.slip", live_command, "already exists"},
        RefusedSetting{"record: '-'", live_command, "use .slip"},
        RefusedSetting{"publish: ['mcap:bashrc']", live_command, "use .mcap"},
        RefusedSetting{"publish: '[mcap:../new.mcap,web:0]'", live_command, "working folder"},
        RefusedSetting{"save-to: ..", live_command, "working folder"},
        RefusedSetting{"save-to: out", live_command, "working folder"},
        RefusedSetting{"model: bashrc", live_command, "use .ply"},
        RefusedSetting{"snapshot: bashrc", live_command, "use .png"},
        RefusedSetting{"screenshot: text.png", live_command, "already exists"},
        RefusedSetting{"preview: bashrc", reconstruct_command, "use .png"},
        RefusedSetting{"preview: text.png", reconstruct_command, "already exists"},
        RefusedSetting{"preview: '{name}/../../{name}.png'", reconstruct_command, "working folder"},
        RefusedSetting{"preview: 'te{name}.png'", reconstruct_command, "already exists"},
        RefusedSetting{"depth: bashrc", reconstruct_command, "use .tiff"},
        RefusedSetting{"mean: bashrc", reconstruct_command, "use .tiff"},
        RefusedSetting{"manifest: bashrc", reconstruct_command, "use .jsonl"},
        RefusedSetting{"log: bashrc", {"project", "--list"}, "use .csv"},
        RefusedSetting{"plots: bashrc", {"reproduce", "--list"}, "folder"},
        RefusedSetting{"publish: ['web:0.0.0.0:0']", live_command, "--public"},
        RefusedSetting{"publish: ['web:[::]:0']", live_command, "--public"},
        RefusedSetting{"publish: ['tcp:0.0.0.0:0']", live_command, "--public"},
        RefusedSetting{"publish: '[web:0.0.0.0:0,web:0]'", live_command, "--public"},
        RefusedSetting{"publish: ['genicam:192.0.2.1']", live_command, "--public"},
        RefusedSetting{"publish: ['ros2:scanner']", live_command, "--public"},
        RefusedSetting{"web: '0.0.0.0:0'", {"view", "scan"}, "--public"},
        RefusedSetting{"address: 0.0.0.0", {"camera", "serve", "--duration", "1"}, "--public"},
        RefusedSetting{"public: true", live_command, "no command has a setting 'public'"}));

TEST_F(RigProgram, WritesNewFilesAndItsOwnAgain) {
  write_rig(
      "source: virtual\nworld: ideal\ncamera: 64x48\nrate: 0\nstrategy: pmp\n"
      "record: below/frames.slip\npreview: 'preview-{name}.png'\n"
      "publish: [mcap:clouds.mcap, 'web:127.0.0.1:0']\n");
  fs::create_directory(path("below"));
  const WorkingFolder folder(folder_.path());

  for (int time = 0; time < 2; ++time) {
    const ProgramRun live = run(live_command);
    EXPECT_EQ(live.exit_code, 0) << live.err;
    const ProgramRun made = run({"reconstruct", "below/frames.slip", "--anyway"});
    EXPECT_EQ(made.exit_code, 0) << made.err;
  }
  for (const char* name : {"below/frames.slip", "clouds.mcap", "preview-frames.png"}) {
    EXPECT_TRUE(fs::is_regular_file(path(name))) << name;
  }
}

TEST_F(RigProgram, ItsMeshIsTheObjectOfTheVirtualScanner) {
  copy_simulated_scan({"--camera", "64x48"}, path("scan"));
  write_rig("mesh: statue.ply\n");
  const WorkingFolder folder(path("rig"));
  const ProgramRun made = run({"reconstruct", path("scan"), "--anyway", "-o", path("cloud.ply")});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_FALSE(fs::exists(path("rig/statue.ply")));
}

TEST_F(RigProgram, TheCommandLineIsTrusted) {
  write_rig(
      "source: virtual\nworld: ideal\ncamera: 64x48\nrate: 0\nstrategy: pmp\n"
      "record: bashrc\npublish: ['web:0.0.0.0:0']\n");
  const WorkingFolder folder(path("rig"));

  const ProgramRun live =
      run({"live", "--frames", "20", "--headless", "--record", path("frames.slip"), "--public"});
  EXPECT_EQ(live.exit_code, 0) << live.err;
  EXPECT_NE((live.out + live.err).find("token="), std::string::npos) << live.out << live.err;
  EXPECT_TRUE(fs::exists(path("frames.slip")));
}

TEST_F(RigProgram, TheExampleOfTheDocumentationWorks) {
  const std::string page =
      contents(fs::path(SLIPSTREAM_SOURCE_FOLDER) / "docs" / "how-to" / "serve.md");
  const std::size_t begin = page.find("# rig.yaml"), end = page.find("```", begin);
  std::string text = page.substr(begin, end - begin);
  text.replace(text.find("scanner: scanner.yaml"), 21, "");
  write_rig(text);
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"simulate", path("scan"), "--camera", "96x72"},
           {"reconstruct", path("scan"), "-o", path("cloud.ply")},
           {"live", "--frames", "40", "--headless", "--camera", "96x72", "--rate", "0"},
           {"record", "--frames", "40", "--camera", "96x72", "-o", path("scan.slip"), "--rate",
            "0"},
           {"check", path("scan.slip")}}) {
    const ProgramRun done = run(arguments);
    EXPECT_EQ(done.exit_code, 0) << arguments[0] << ": " << done.err;
  }
}

TEST(RigProgramWords, AreGuessed) {
  const TemporaryFolder folder;
  const std::string out = folder.path() / "out";
  fs::create_directory(folder.path() / "scan");
  for (const auto& [arguments, part] :
       std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"recnstruct", "scan"}, "did you mean reconstruct?"},
           {{"calibrate", "gama"}, "did you mean gamma?"},
           {{"simulate", out, "--stratgy", "pmp"},
            "simulate has no --stratgy; did you mean "
            "--strategy?"},
           {{"simulate", out, "--stps=3"}, "did you mean --steps?"},
           {{"simulate", out, "--strategy", "pmpc"}, "did you mean pmp?"},
           {{"simulate", out, "--scene", "statute"}, "did you mean statue?"},
           {{"live", "--source", "virtul"}, "did you mean virtual?"},
           {{"live", "--source", folder.path() / "scan"}, "did you mean replay:"}}) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
  }
  EXPECT_EQ(run_program({"xyzzyx"}).err.find("did you mean"), std::string::npos);
}

TEST(RigProgramErrors, NoScanIsWrittenOverAnother) {
  const TemporaryFolder folder;
  for (const char* name : {"scan", "scan.slip"}) {
    ASSERT_EQ(run_program({"simulate", folder.path() / name, "--camera", "64x48"}).exit_code, 0);
  }
  const ProgramRun run =
      run_program({"reconstruct", folder.path() / "scan", folder.path() / "scan.slip", "-o",
                   folder.path() / "{name}.ply"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("scan.ply"), std::string::npos) << run.err;
}

TEST(RigProgramErrors, AreInTheDocumentToo) {
  const TemporaryFolder folder;
  const std::string scan = folder.path() / "scan";
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"reconstruct", "nowhere", "--json"},
                                             {"simulate", "--json", "--nothing"},
                                             {"live", "--json", "--source", "nothing"}}) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 2);
    const nlohmann::json document = nlohmann::json::parse(run.out);
    EXPECT_EQ("slipstream: " + document["error"].get<std::string>() + "\n", run.err);
  }
  ASSERT_EQ(run_program({"simulate", scan, "--camera", "160x120"}).exit_code, 0);
  // Two swapped frames: refused.
  const ProgramRun refused = run_program({"reconstruct", scan, "--order", "1,0,2,3,4,5", "--json"});
  EXPECT_EQ(refused.exit_code, 2) << refused.err;
  const nlohmann::json document = nlohmann::json::parse(refused.out);
  ASSERT_FALSE(document["findings"].empty()) << refused.out;
  EXPECT_EQ(document["findings"][0]["refused"], true);
  // The suggested order refers to the frames in file order.
  EXPECT_NE(document["error"].get<std::string>().find("omit --order"), std::string::npos)
      << document["error"];
}

}  // namespace slipstream::rig_program_test
