// What is no scan, and a world that does not take what is written: one line and an exit code.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

#include "slipstream/io/recording.h"
#include "tests/app/program.h"

namespace slipstream::hostile_input_test {
namespace fs = std::filesystem;

class HostileInput : public testing::Test {
 protected:
  void SetUp() override { copy_simulated_scan({"--camera", "64x48"}, path("scan")); }

  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_.path() / name).string();
  }

  static void expect_refused(const std::vector<std::string>& arguments, const std::string& part,
                             int exit_code = 2) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err << "lacks: " << part;
  }

  /// As a shell runs it, with redirections; its exit code, and what it says on stderr.
  [[nodiscard]] std::pair<int, std::string> in_shell(const std::string& words) const {
    const std::string command = SLIPSTREAM_PROGRAM " " + words + " 2>" + path("err");
    const int status = std::system(command.c_str());  // NOLINT(cert-env33-c)
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), contents(path("err"))};
  }

  TemporaryFolder folder_;
};

TEST_F(HostileInput, PipesDevicesAndLinksInARingAreRefusedAtOnce) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  fs::create_symlink(path("ring"), path("ring"));
  const std::string wanted = "expected a file", ring = "symbolic links";
  for (const std::string& special : {path("pipe"), std::string("/dev/zero")}) {
    expect_refused({"reconstruct", path("scan"), "--scanner", special}, wanted);
    expect_refused({"reconstruct", path("scan"), "--rig", special}, wanted);
    expect_refused({"simulate", path("other"), "--virtual-gamma", special}, wanted);
    expect_refused({"live", "--source", "replay:" + special, "--headless"}, wanted);
    for (const char* name : {"frame_00.png", "scan.yaml"}) {
      const fs::path kept = path("kept"), replaced = folder_.path() / "scan" / name;
      fs::rename(replaced, kept);
      fs::create_symlink(special, replaced);
      expect_refused({"reconstruct", path("scan")}, wanted);
      fs::rename(kept, replaced);
    }
  }
  expect_refused({"reconstruct", path("ring")}, ring);
  expect_refused({"reconstruct", path("scan"), "--scanner", path("ring")}, ring);
  expect_refused({"check", std::string(5000, 'n')}, "name too long");
  for (const std::string& special : {path("pipe"), std::string("/dev/null")}) {
    expect_refused(
        {"reconstruct", path("scan"), "-o", path("cloud.ply"), "--manifest", special, "--resume"},
        special, 1);
  }
}

TEST_F(HostileInput, OutputsAreNeitherInputsNorTwice) {
  const std::string frame = path("scan/frame_00.png"), before = contents(frame);
  fs::create_symlink(frame, path("link.png"));
  for (const std::string& preview :
       {frame, path("scan/../scan/./frame_00.png"), path("link.png")}) {
    expect_refused({"reconstruct", path("scan"), "--preview", preview}, "is an input");
  }
  expect_refused({"reconstruct", path("scan"), "--preview", path("scan/{name}_00.png"), "--depth",
                  path("a.tiff"), "--mean", path("./a.tiff")},
                 "two outputs");
  expect_refused(
      {"reconstruct", path("scan"), "--mesh", path("a.obj"), "--preview", path("a-texture.png")},
      "two outputs");
  expect_refused({"live", "--frames", "4", "--headless", "--camera", "64x48", "-o",
                  path("same.ply"), "--record", path("same.ply")},
                 "two outputs");
  expect_refused({"live", "--frames", "4", "--headless", "--camera", "64x48", "--publish",
                  "mcap:" + path("same.mcap"), "--record", path("same.mcap")},
                 "two outputs");
  const std::string description = path("scan/scan.yaml");
  for (const std::string& output : {frame, description}) {
    expect_refused({"calibrate", "gamma", path("scan"), "-o", output}, "is an input");
    expect_refused(
        {"calibrate", "gamma", path("scan"), "-o", path("a.yaml"), "--histogram", output},
        "is an input");
    expect_refused(
        {"calibrate", "ambient", path("scan"), "-o", path("a.yaml"), "--histogram", output},
        "is an input");
    expect_refused({"unwrap", output, "-o", output}, "is an input");
  }
  EXPECT_EQ(contents(frame), before);
  EXPECT_FALSE(fs::exists(path("a.tiff")));
}

TEST_F(HostileInput, ARecordingThatASignalEndsLeavesNothing) {
  const std::string recording = path("large.slip");
  std::ofstream(recording) << "old";
  RunningProgram program({"simulate", recording, "--camera", "640x480", "--steps", "64"});
  EXPECT_TRUE(wait_until([&] {
    return std::any_of(fs::directory_iterator(folder_.path()), fs::directory_iterator(),
                       [](const auto& entry) { return entry.path().extension() == ".part"; });
  }));
  program.send(SIGTERM);
  EXPECT_NE(program.wait(), 0);
  EXPECT_EQ(contents(recording), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 2);
}

TEST_F(HostileInput, StandardOutputThatTakesNothingIsAFailure) {
  const auto expect_told = [&](const std::string& words) {
    const auto [code, err] = in_shell(words);
    EXPECT_EQ(code, 1) << words;
    EXPECT_NE(err.find("standard output"), std::string::npos) << err;
  };
  expect_told("--help >/dev/full");
  expect_told("--version >/dev/full");
  expect_told("reconstruct " + path("scan") + " -o " + path("cloud.ply") + " >&-");
  EXPECT_TRUE(fs::exists(path("cloud.ply")));
  const std::string closed = SLIPSTREAM_PROGRAM " check " + path("scan") + " <&- >&- 2>&-";
  EXPECT_EQ(WEXITSTATUS(std::system(closed.c_str())), 1);  // NOLINT(cert-env33-c)
}

TEST_F(HostileInput, AFileThatMayNotGrowIsToldAndGone) {
  const std::string command = "ulimit -f 1; exec " SLIPSTREAM_PROGRAM " reconstruct " +
                              path("scan") + " --depth " + path("depth.tiff") + " >" + path("out") +
                              " 2>" + path("err");
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 1);  // NOLINT(cert-env33-c)
  EXPECT_NE(contents(path("err")).find("File too large"), std::string::npos);
  for (const auto& entry : fs::directory_iterator(folder_.path())) {
    EXPECT_EQ(entry.path().string().find("depth"), std::string::npos) << entry.path();
  }
}

TEST_F(HostileInput, HangingUpFinishesARecording) {
  RunningProgram record({"record", "--source", "virtual", "--camera", "64x48", "--rate", "50", "-o",
                         path("frames.slip")});
  ASSERT_TRUE(wait_until([&] {
    std::error_code none;
    return fs::file_size(path("frames.slip"), none) > 100000 && !none;
  }));
  record.send(SIGHUP);
  EXPECT_EQ(record.wait(), 0) << record.err();
  EXPECT_TRUE(RecordingReader(path("frames.slip")).finished());
}

TEST_F(HostileInput, LibrariesSayNothingOfTheirOwn) {
  // The header is whole, and what follows is not.
  const std::string truth = contents(path("scan/truth/depth.tiff"));
  std::string bytes = truth;
  std::fill(bytes.begin() + 100, bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2), 0);
  std::ofstream(path("scan/frame_00.png")) << bytes;
  expect_refused({"reconstruct", path("scan")}, "frame_00.png");
}

TEST_F(HostileInput, ADamagedTruthIsFoundBeforeAnythingIsWritten) {
  fs::resize_file(path("scan/truth/depth.tiff"), 1000);
  expect_refused({"reconstruct", path("scan"), "--anyway", "-o", path("cloud.ply")}, "depth.tiff");
  EXPECT_FALSE(fs::exists(path("cloud.ply")));
}

TEST_F(HostileInput, ControlCharactersDoNotReachTheTerminal) {
  std::ofstream(path("scan/scan.yaml"), std::ios::app) << "\"\\e[31mred\\a\\x9bm\": 1\n";
  for (const ProgramRun& run :
       {run_program({"check", path("scan")}), run_program({"check", path("\x1b[31m")}),
        run_program({"check", path("scan"), "--json"}),
        run_program({"live", "--fr\x1b[31mames"})}) {
    EXPECT_EQ(run.exit_code, 2);
    for (const char c : {'\x1b', '\a', '\x9b'}) {
      EXPECT_EQ((run.err + run.out).find(c), std::string::npos) << run.err;
    }
  }
}

TEST_F(HostileInput, NumbersThatAreNone) {
  const auto simulate = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> words{"simulate", path("other"), "--camera", "64x48"};
    words.insert(words.end(), flags.begin(), flags.end());
    return words;
  };
  const std::vector<std::string> live{"live", "--headless", "--duration", "1"};
  const auto with = [](std::vector<std::string> words, const std::string& flag) {
    words.push_back(flag);
    return words;
  };
  expect_refused(with(live, "--frames=-1"), "below 0");
  expect_refused(with(live, "--frames="), "--frames");
  expect_refused({"record", "--source", "virtual", "-o", path("x.slip"), "--frames", ""},
                 "missing");
  expect_refused(simulate({"--motion", "nan", "nan", "nan"}), "not finite");
  expect_refused(simulate({"--virtual-ambient", "1e308"}), "ambient");
  expect_refused(simulate({"--virtual-noise", "1e308"}), "noise");
  expect_refused(simulate({"--seed=-1"}), "below 0");
  expect_refused({"simulate", path("other"), "--camera", "60000x60000"}, "160000000 pixels");
  expect_refused({"reconstruct", path("scan"), "--noise-variance", "1e308"}, "noise variance");
  expect_refused({"reconstruct", path("scan"), "--nearest", "inf"}, "not finite");
  EXPECT_FALSE(fs::exists(path("other")));
}

}  // namespace slipstream::hostile_input_test
