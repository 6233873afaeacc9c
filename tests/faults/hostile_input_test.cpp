// What is no scan, and a world that does not take what is written: one line and an exit code.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <signal.h>
#include <sys/stat.h>

#include "slipstream/recording.h"
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
  expect_refused({"simulate", path("other"), "--rig", path("scan")}, wanted);
  expect_refused({"reconstruct", path("ring")}, ring);
  expect_refused({"reconstruct", path("scan"), "--scanner", path("ring")}, ring);
  expect_refused({"check", std::string(5000, 'n')}, "name too long");
  for (const std::string& special : {path("pipe"), std::string("/dev/null")}) {
    expect_refused(
        {"reconstruct", path("scan"), "-o", path("cloud.ply"), "--manifest", special, "--resume"},
        special, 1);
  }
}

TEST_F(HostileInput, FilesAboveTheirLimitAreRefused) {
  fs::create_directory(path("cut"));
  fs::copy(path("scan"), path("cut"));
  const std::uintmax_t mebi = 1 << 20, gibi = 1 << 30;

  for (const auto& [name, limit, arguments] :
       std::vector<std::tuple<std::string, std::uintmax_t, std::vector<std::string>>>{
           {"cut/scan.yaml", mebi, {"check", path("cut")}},
           {"cut/scanner.yaml", mebi, {"check", path("scan"), "--scanner"}},
           {"rig.yaml", mebi, {"check", path("scan"), "--rig"}},
           {"poses.txt", mebi, {"merge", path("scan"), path("scan"), "--start"}},
           {"scanner.npz", 64 * mebi, {"check", path("scan"), "--scanner"}},
           {"map.tiff", 2 * gibi - 1, {"unwrap", "-o", path("phase.npy")}},
           {"cloud.ply", 4 * gibi, {"convert", "-o", path("cloud.pcd")}},
           {"mesh.ply", 4 * gibi, {"simulate", path("other"), "--mesh"}},
           {"list.txt", 4 * gibi, {"reconstruct", "-o", path("{name}.ply")}},
           {"done.jsonl",
            4 * gibi,
            {"reconstruct", path("scan"), "-o", path("a.ply"), "--resume", "--manifest"}}}) {
    std::ofstream(path(name), std::ios::app) << "";
    fs::resize_file(path(name), limit + 1);
    std::vector<std::string> words = arguments;
    if (name != "cut/scan.yaml") words.push_back(path(name));
    expect_refused(words, fmt::format("has {} bytes; limit {}", limit + 1, limit));
    fs::resize_file(path(name), 0);
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
  expect_refused({"reconstruct", path("scan"), path("scan/frame_00.png"), "-o", path("a.ply")},
                 "give their folder");
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

TEST_F(HostileInput, OutputsAreNothingThatAFolderHolds) {
  const std::string scan = path("scan"), bare = path("bare"), poses = path("poses");
  fs::create_directory(bare);
  for (const char* name : {"frame_00.png", "frame_01.png"}) fs::copy(scan + "/" + name, bare);
  fs::create_directories(poses + "/one");
  for (const char* axis : {"x", "y"}) fs::copy(bare, poses + "/one/" + axis);
  fs::copy(scan, path("scan-000000"), fs::copy_options::recursive);
  fs::create_directories(path("in/folder"));
  std::ofstream(path("in/a.ply")) << "ply";
  const std::string input = "is an input", holds = "holds inputs";
  const auto expect_unchanged = [&](std::vector<std::string> arguments, const std::string& output,
                                    const std::string& part) {
    const std::string before = fs::is_regular_file(output) ? contents(output) : "";
    arguments.push_back(output);
    expect_refused(arguments, part);
    EXPECT_EQ(fs::is_regular_file(output) ? contents(output) : "", before);
  };
  // What a scan's folder holds besides its frames.
  for (const char* flag : {"--depth", "--mean", "--preview"}) {
    expect_unchanged({"reconstruct", scan, flag}, scan + "/truth/depth.tiff", input);
  }
  expect_unchanged({"live", "--source", "replay:" + scan, "--headless", "--screenshot"},
                   scan + "/truth/depth.tiff", input);
  // Pictures of a folder that nothing describes, also ones that would become frames.
  for (const char* name : {"/frame_01.png", "/new.png"}) {
    expect_unchanged({"reconstruct", bare, "--strategy", "pmp", "--preview"}, bare + name, input);
    expect_unchanged({"view", bare, "--strategy", "pmp", "--snapshot"}, bare + name, input);
  }
  // Poses of a board.
  for (const char* axis : {"x", "y"}) {
    const std::string pose = poses + "/one/" + axis;
    expect_unchanged({"calibrate", "geometry", poses, "-o", path("a.yaml"), "--report"}, pose,
                     holds);
    expect_unchanged({"calibrate", "geometry", poses, "-o"}, pose + "/frame_00.png", input);
  }
  // Placeholders.
  expect_unchanged({"convert", path("in/a.ply"), "-o"}, path("in/{name}.ply"), input);
  expect_unchanged({"convert", path("scan-000000"), "-o"}, path("scan-{window}"), input);
  // Folders.
  expect_unchanged({"simulate", "--scanner", scan + "/scanner.yaml"}, scan, holds);
  expect_unchanged({"compare", "--mesh", path("in/a.ply"), "-o"}, path("in/a.ply"), holds);
  EXPECT_FALSE(fs::exists(path("a.yaml")));
  EXPECT_FALSE(fs::exists(bare + "/new.png"));
}

TEST_F(HostileInput, OutputsBesideTheScanAreWrittenAgainAndAgain) {
  for (int run = 0; run < 3; ++run) {
    EXPECT_EQ(run_program({"reconstruct", path("scan"), "-o", path("scan/{name}.ply"), "--preview",
                           path("scan/preview.png"), "--mesh", path("scan/mesh.obj")})
                  .exit_code,
              0);
  }
}

TEST_F(HostileInput, ARecordingThatASignalEndsLeavesNothing) {
  const std::string recording = path("large.slip");
  std::ofstream(recording) << "old";
  const auto has_part = [&] {
    return std::any_of(fs::directory_iterator(folder_.path()), fs::directory_iterator(),
                       [](const auto& entry) { return entry.path().extension() == ".part"; });
  };

  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGKILL}) {
    RunningProgram program({"simulate", recording, "--camera", "640x480", "--steps", "64"});
    EXPECT_TRUE(wait_until(has_part));
    program.send(signal);
    EXPECT_NE(program.wait(), 0);
    EXPECT_EQ(contents(recording), "old");
    EXPECT_EQ(has_part(), signal == SIGKILL) << signal;
  }
}

TEST_F(HostileInput, AScanIsDescribedOnceItsFramesAreThere) {
  const long less_than_a_frame = 1000;
  const ProgramRun run =
      run_program({"simulate", path("cut"), "--camera", "64x48"}, less_than_a_frame);
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_FALSE(fs::exists(path("cut/scan.yaml")));
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

TEST_F(HostileInput, AClosedPipeEndsItQuietly) {
  // The reader has gone before the program starts.
  const auto run = [&](const std::string& words) {
    const std::string command = fmt::format("bash -c 'exec 3> >(:); wait $!; {} {} >&3 2>{}'",
                                            SLIPSTREAM_PROGRAM, words, path("err"));
    const int status = std::system(command.c_str());  // NOLINT(cert-env33-c)
    return WEXITSTATUS(status);
  };
  for (const char* words : {"--help", "--version", "live --help"}) {
    EXPECT_EQ(run(words), 128 + SIGPIPE) << words;
    EXPECT_EQ(contents(path("err")), "");
  }
  EXPECT_EQ(run("reconstruct " + path("scan") + " --json --depth " + path("depth.tiff")),
            128 + SIGPIPE);
  EXPECT_EQ(contents(path("err")).find("slipstream:"), std::string::npos);
  EXPECT_EQ(run("live --source virtual --camera 64x48 --world ideal --rate 50 --headless "
                "--duration 1 --record " +
                path("a.slip")),
            128 + SIGPIPE);
  // A slow machine may print how far the rendering is.
  EXPECT_EQ(contents(path("err")).find("slipstream:"), std::string::npos);
  EXPECT_TRUE(RecordingReader(path("a.slip")).finished());
  for (const auto& entry : fs::directory_iterator(folder_.path())) {
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
  }
  const std::string ignored =
      fmt::format("bash -c 'exec 3> >(:); wait $!; trap \"\" PIPE; {} --help >&3 2>{}'",
                  SLIPSTREAM_PROGRAM, path("err"));
  EXPECT_EQ(WEXITSTATUS(std::system(ignored.c_str())), 1);  // NOLINT(cert-env33-c)
  EXPECT_NE(contents(path("err")).find("standard output"), std::string::npos);
}

TEST_F(HostileInput, AFileThatMayNotGrowIsToldAndGone) {
  // Without counts for ./dev coverage, which would be cut off and spoil those of all others.
  const std::string command =
      "ulimit -f 1; GCOV_PREFIX=/dev/null exec " SLIPSTREAM_PROGRAM " reconstruct " + path("scan") +
      " --depth " + path("depth.tiff") + " >" + path("out") + " 2>" + path("err");
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 1);  // NOLINT(cert-env33-c)
  EXPECT_NE(contents(path("err")).find("File too large"), std::string::npos);
  for (const auto& entry : fs::directory_iterator(folder_.path())) {
    EXPECT_EQ(entry.path().string().find("depth"), std::string::npos) << entry.path();
  }
}

TEST_F(HostileInput, ASignalFinishesARecordingAndAKillCostsNoWholeFrame) {
  const std::vector<std::string> record{
      "record", "--source", "virtual", "--camera",          "64x48",
      "--rate", "50",       "-o",      path("frames.slip"), "--frames"};
  const auto run_until_frames = [&](const std::string& frames) {
    std::vector<std::string> words = record;
    words.push_back(frames);
    RunningProgram program(words);
    EXPECT_TRUE(wait_until([&] {
      std::error_code none;
      return fs::file_size(path("frames.slip"), none) > 100000 && !none;
    }));
    return program;
  };

  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGKILL}) {
    RunningProgram program = run_until_frames("1000000");
    program.send(signal);
    EXPECT_EQ(program.wait(), signal == SIGKILL ? -SIGKILL : 0) << program.err();

    const RecordingReader reader(path("frames.slip"));
    EXPECT_EQ(reader.finished(), signal != SIGKILL);
    EXPECT_LE(reader.dropped(), 1U);
    EXPECT_GE((reader.count() + 1) * (64 * 48 + 64), 100000U);
    fs::remove(path("frames.slip"));
  }

  // As with nohup.
  const auto before = ::signal(SIGHUP, SIG_IGN);
  RunningProgram program = run_until_frames("100");
  ::signal(SIGHUP, before);
  program.send(SIGHUP);
  EXPECT_EQ(program.wait(), 0) << program.err();
  EXPECT_EQ(RecordingReader(path("frames.slip")).count(), 100U);
}

TEST_F(HostileInput, ASecondSignalEndsARunThatCannotComplete) {
  // The cloud, which the first signal brings, does not fit into a pipe that nobody reads.
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  const std::string command = fmt::format(
      "bash -c 'exec 3<>{0}; {1} live --source virtual --world ideal --camera 320x240 --rate 50"
      " --headless --record {2} -o - >&3 2>{3} & until [ -s {2} ]; do sleep 0.1; done; sleep 2;"
      " kill -TERM $!; sleep 2; kill -TERM $!; wait $!'",
      path("pipe"), SLIPSTREAM_PROGRAM, path("a.slip"), path("err"));
  const int status = std::system(command.c_str());  // NOLINT(cert-env33-c)
  EXPECT_EQ(WEXITSTATUS(status), 128 + SIGTERM) << contents(path("err"));
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
    EXPECT_NE(run.err.find("\\x1b[31m"), std::string::npos) << run.err;
  }
}

TEST_F(HostileInput, NamesWithControlCharactersStayOnTheirLine) {
  const std::string scan = path("a\x1b[31mb\nQZ");
  fs::rename(path("scan"), scan);
  ASSERT_EQ(run_program({"reconstruct", scan, "--anyway", "-o", path("e\nQZ.pcd")}).exit_code, 0);

  const std::vector<std::vector<std::string>> commands{
      {"check", scan},
      {"reconstruct", scan, "--anyway", "-o", path("f\nQZ.ply"), "--depth", path("g\nQZ.tiff")},
      {"reconstruct", scan, path("missing\nQZ"), "--anyway"},
      {"measure", path("e\nQZ.pcd"), "--plane", "all"},
      {"convert", path("e\nQZ.pcd"), "-o", path("h\nQZ.mcap")},
      {"convert", scan, "--anyway", "-o", path("i\nQZ.slip")},
      {"batch", "plan", scan, "--tasks", "1", "--anyway", "-o", path("{name}.ply"), "--plan",
       path("plan\nQZ")},
      {"simulate", path("j\nQZ"), "--camera", "16x12"},
      {"live", "--source", "replay:" + scan, "--headless"}};

  for (std::vector<std::string> arguments : commands) {
    for (const bool json : {false, true}) {
      if (json) arguments.emplace_back("--json");
      const ProgramRun run = run_program(arguments);
      const std::string words = run.err + run.out;

      // After the break of a name would come "QZ", which begins no other line.
      EXPECT_EQ(std::ranges::count_if(words, [](char c) { return c != '\n' && std::iscntrl(c); }),
                0)
          << words;
      EXPECT_EQ(words.find("\nQZ"), std::string::npos) << words;
      const bool names_it = !json && run.exit_code == 0 && words.find("QZ") != std::string::npos;
      EXPECT_TRUE(!names_it || words.find("\\x0aQZ") != std::string::npos) << words;
      EXPECT_GE(run.exit_code, 0) << words;
      EXPECT_TRUE(!json || nlohmann::json::accept(run.out)) << run.out;
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
