// Scans with inconsistent frames: warned about, refused, repaired or marked.
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include "io/file.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/grey_image.h"
#include "tests/io/temporary_folder.h"
#include "tests/shared_data.h"

namespace slipstream::check_program_test {
namespace fs = std::filesystem;

bool says(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

/// A virtual scan in scan/: two bands of three frames each.
class CheckProgram : public testing::Test {
 protected:
  void SetUp() override { copy_simulated_scan({"--camera", "160x120"}, path("scan")); }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }
  [[nodiscard]] std::string frame(int n) const {
    return path("scan/frame_0" + std::to_string(n) + ".png");
  }

  /// Replaces each frame n with the previous frame `order[n]`.
  void rename_frames(const std::vector<int>& order) const {
    for (int n = 0; n < 6; ++n) fs::rename(frame(n), frame(n) + ".was");
    for (int n = 0; n < 6; ++n) {
      fs::rename(frame(order[static_cast<std::size_t>(n)]) + ".was", frame(n));
    }
  }
  /// Swaps two frames of the first band, which reverses its phase.
  void swap_frames() const { rename_frames({0, 2, 1, 3, 4, 5}); }

  void expect_one_line(const ProgramRun& run, const std::vector<std::string>& parts) const {
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    for (const std::string& part : parts) EXPECT_TRUE(says(run.err, part)) << run.err << part;
    EXPECT_FALSE(fs::exists(path("cloud.ply")));
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(CheckProgram, FindsNothingAmissInAGoodScan) {
  const ProgramRun run = run_program({"check", path("scan"), path("scan")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::string line = path("scan") + ": OK: no problems found\n";
  const std::string scale =
      path("scan") + ": baseline 186.3 mm, median depth of the pixels checked ";
  EXPECT_TRUE(run.out.starts_with(line + scale)) << run.out;
  EXPECT_TRUE(says(run.out, " mm\n" + line + scale)) << run.out;
  EXPECT_EQ(run.err, "");
  const ProgramRun told = run_program({"check", path("scan"), "--json"});
  EXPECT_EQ(told.exit_code, 0);
  EXPECT_TRUE(says(told.out, "\"scans\"") && says(told.out, "\"findings\": []")) << told.out;
}

TEST_F(CheckProgram, TellsTheScaleOfAScannerFile) {
  const ProgramRun right = run_program({"reconstruct", path("scan"), "--json"});
  EXPECT_EQ(right.exit_code, 0) << right.err;
  EXPECT_TRUE(says(right.out, "\"baseline_mm\": 186.") && says(right.out, "\"median_depth_mm\""));
  EXPECT_TRUE(says(right.err, "  baseline 186.3 mm, median depth of the points ")) << right.err;
  const ProgramRun none =
      run_program({"reconstruct", path("scan"), "--box", "0,0,1,1,1,2", "--anyway"});
  EXPECT_TRUE(says(none.out, ": 0 points of ")) << none.out;
  EXPECT_TRUE(says(none.out, "mm, median depth of the pixels checked ")) << none.out;
  Scanner scanner = read_scanner(path("scan/scanner.yaml"));
  scanner.translation /= 10;
  scanner.calibrated_depths.reset();
  write_scanner(path("cm.yaml"), scanner);
  for (const std::string command : {"check", "reconstruct"}) {
    const ProgramRun run = run_program({command, path("scan"), "--scanner", path("cm.yaml")});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_TRUE(says(run.out + run.err, "in centimetres or inches")) << run.out << run.err;
  }
}

/// What the program writes to stderr if that is a terminal of so many columns.
std::string on_terminal(const std::vector<std::string>& arguments, unsigned short columns) {
  const winsize size{.ws_row = 24, .ws_col = columns, .ws_xpixel = 0, .ws_ypixel = 0};
  std::vector<const char*> words{SLIPSTREAM_PROGRAM};
  for (const std::string& argument : arguments) words.push_back(argument.c_str());
  words.push_back(nullptr);

  int terminal = -1;
  const pid_t process = ::forkpty(&terminal, nullptr, nullptr, &size);
  if (process == 0) {
    if (std::freopen("/dev/null", "w", stdout) == nullptr) ::_exit(126);
    ::execv(words[0], const_cast<char* const*>(words.data()));
    ::_exit(127);
  }

  std::string written;
  std::array<char, 4096> part{};
  for (ssize_t got = 0; (got = ::read(terminal, part.data(), part.size())) > 0;) {
    written.append(part.data(), static_cast<std::size_t>(got));
  }
  ::close(terminal);
  ::waitpid(process, nullptr, 0);
  return written;
}

/// Letters past the last column of a terminal, of lines that it wraps and of those that it cuts.
struct PastTheEdge {
  int wrapped = 0, cut = 0;
};

PastTheEdge past_the_edge(std::string_view written, int columns) {
  PastTheEdge past;
  bool wraps = true;
  int column = 0;

  while (!written.empty()) {
    const char letter = written.front();
    if (letter == '\033') {
      const std::string_view code = written.substr(0, written.find_first_of("hlK") + 1);
      if (code == "\033[?7l" || code == "\033[?7h") wraps = code.back() == 'h';
      written.remove_prefix(code.size());
      continue;
    }

    column = letter == '\r' || letter == '\n' ? 0 : column + 1;
    if (column > columns) ++(wraps ? past.wrapped : past.cut);
    written.remove_prefix(1);
  }
  return past;
}

TEST_F(CheckProgram, LinesOfProgressAreCutAtTheTerminalsWidth) {
  constexpr int columns = 40;
  const std::string scan = path("scan"), long_name = path(std::string(60, 'x'));
  fs::copy(scan, long_name);

  for (const auto& [arguments, line] :
       std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"reconstruct", long_name, "-o", path("cloud.ply")}, ": reconstructing ..."},
           {{"check", scan, long_name}, "scans [...."},
           {{"measure", long_name, "--plane", "20x20+30+30"}, ": reading ..."}}) {
    const std::string written = on_terminal(arguments, columns);
    EXPECT_NE(written.find(line), std::string::npos) << written;

    const auto [wrapped, cut] = past_the_edge(written, columns);
    EXPECT_EQ(wrapped, 0) << written;
    EXPECT_GT(cut, 0) << written;
    EXPECT_TRUE(written.ends_with("\033[K")) << "stays in part: " << written;
  }
}

TEST_F(CheckProgram, NeedsNoScanner) {
  for (int n = 0; n < 6; ++n) {
    fs::create_directories(path("bare"));
    fs::copy(frame(n), path("bare"));
  }
  const std::vector<std::string> patterns{"--strategy", "dual-frequency", "--steps", "3", "--high",
                                          "16",         "--low",          "1"};
  std::vector<std::string> check{"check", path("bare")}, reconstruct{"reconstruct", path("bare")};
  check.insert(check.end(), patterns.begin(), patterns.end());
  reconstruct.insert(reconstruct.end(), patterns.begin(), patterns.end());
  const ProgramRun run = run_program(check);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, path("bare") + ": OK: no problems found\n");
  reconstruct.insert(reconstruct.end(), {"-o", path("cloud.ply")});
  expect_one_line(run_program(reconstruct), {"no scanner", "--phase FILE"});

  // A mistake that the frames show comes first.
  reconstruct.insert(reconstruct.end(), {"--order", "1,0,2,3,4,5"});
  expect_one_line(run_program(reconstruct), {"look swapped"});
}

TEST_F(CheckProgram, RefusesScansThatCannotBeRead) {
  expect_one_line(run_program({"check"}), {"folders"});
  expect_one_line(run_program({"check", path("nowhere")}), {"nowhere"});
  expect_one_line(run_program({"check", path("scan"), "--steps", "4"}), {"has 8"});
}

TEST_F(CheckProgram, TakesPicturesInAnotherOrder) {
  ASSERT_EQ(run_program({"reconstruct", path("scan"), "-o", path("right.ply")}).exit_code, 0);
  rename_frames({1, 2, 0, 5, 3, 4});
  const ProgramRun run =
      run_program({"reconstruct", path("scan"), "--order", "2,0,1,4,5,3", "-o", path("cloud.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(contents(path("cloud.ply")), contents(path("right.ply")));
  EXPECT_EQ(run_program({"check", path("scan"), "--order", "2,0,1,4,5,3"}).exit_code, 0);
}

TEST_F(CheckProgram, TakesPicturesWhoseCodeComesFirst) {
  const std::vector<std::string> patterns{"--strategy", "gray-phase", "--steps", "3",
                                          "--periods",  "4",          "--axis",  "x"};
  fs::remove_all(path("scan"));
  std::vector<std::string> simulate{"simulate", path("scan"), "--camera", "160x120"};
  simulate.insert(simulate.end(), patterns.begin(), patterns.end());
  ASSERT_EQ(run_program(simulate).exit_code, 0);
  ASSERT_EQ(run_program({"reconstruct", path("scan"), "-o", path("right.ply")}).exit_code, 0);
  rename_frames({3, 4, 5, 0, 1, 2});  // three phase steps, then a code of three frames
  const auto reconstructed = [&](const std::string& order) {
    return run_program({"reconstruct", path("scan"), "--order", order, "-o", path("cloud.ply")});
  };
  ASSERT_EQ(reconstructed("code,sinusoids").exit_code, 0);
  EXPECT_EQ(contents(path("cloud.ply")), contents(path("right.ply")));
  EXPECT_TRUE(says(reconstructed("sinusoids,code").err, "the order 3,4,5,0,1,2 corrects this"));
  EXPECT_EQ(contents(path("cloud.ply")), contents(path("right.ply")));
}

TEST_F(CheckProgram, RefusesWhatIsNoOrder) {
  const auto reconstructed = [&](const std::string& order) {
    return run_program({"reconstruct", path("scan"), "--order", order, "-o", path("cloud.ply")});
  };
  for (const std::string order : {"0,1,2", "0,1,2,3,4,4", "1,2,3,4,5,6", "0,1,2,3,4,5,6"}) {
    expect_one_line(reconstructed(order), {path("scan"), "--order " + order, "0 to 5"});
  }
  for (const std::string order : {"a", "0;1;2;3;4;5", "0,1,2,3,4,5,", "0,1,2,3,4,-5"}) {
    expect_one_line(reconstructed(order), {"--order '" + order + "'", "numbers or ranges"});
  }
  expect_one_line(reconstructed("code,sinusoids"), {"dual-frequency has only one of them"});
  // `patterns` has no frames to reorder.
  expect_one_line(run_program({"patterns", path("new"), "--order", "0,1,2"}), {"--order"});
}

TEST_F(CheckProgram, ReconstructTellsWhatTheCheckFoundAndTook) {
  const ProgramRun run = run_program({"reconstruct", path("scan"), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(says(run.out, "\"findings\": []")) << run.out;
  EXPECT_TRUE(says(run.out, "\"check\": ")) << run.out;
  EXPECT_FALSE(says(run.out, "\"doubted\"")) << run.out;
  EXPECT_TRUE(says(run.err, "to check")) << run.err;
}

TEST_F(CheckProgram, ASoundScanIsNotMarkedByAnyway) {
  ASSERT_EQ(
      run_program({"reconstruct", path("scan"), "--anyway", "-o", path("cloud.ply")}).exit_code, 0);
  EXPECT_FALSE(says(contents(path("cloud.ply")), "doubted"));
}

TEST_F(CheckProgram, LiveAndRecordTellThatNothingIsAmiss) {
  const std::vector<std::string> source{"--source", "virtual", "--camera", "96x72",
                                        "--frames", "40",      "--json"};
  std::vector<std::string> live{"live", "--headless"};
  live.insert(live.end(), source.begin(), source.end());
  std::vector<std::string> record{"record", "-o", path("frames.slip")};
  record.insert(record.end(), source.begin(), source.end());
  for (const auto& arguments : {live, record}) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_TRUE(says(run.out, "\"findings\": []")) << run.out;
    EXPECT_FALSE(says(run.err, "warning")) << run.err;
  }
}

TEST_F(CheckProgram, RefusesFramesThatChangedPlaces) {
  swap_frames();
  const ProgramRun check = run_program({"check", path("scan"), "--json"});
  EXPECT_EQ(check.exit_code, 2) << check.out;
  EXPECT_TRUE(says(check.out, "\"refused\": true")) << check.out;
  expect_one_line(run_program({"reconstruct", path("scan"), "-o", path("cloud.ply")}),
                  {path("scan"), "frame", "1", "2"});
  EXPECT_EQ(run_program({"check", path("scan"), "--order", "0,2,1,3,4,5"}).exit_code, 0);
}

TEST_F(CheckProgram, MarksWhatAnywayReconstructs) {
  swap_frames();
  for (const std::string ending : {"ply", "pcd"}) {
    const std::string cloud = path("cloud." + ending);
    const ProgramRun run =
        run_program({"reconstruct", path("scan"), "--anyway", "--json", "-o", cloud});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_TRUE(says(run.err, "warning: " + path("scan"))) << run.err;
    EXPECT_TRUE(says(run.out, "\"doubted\": true")) << run.out;
    EXPECT_TRUE(says(run.out, "\"refused\": true")) << run.out;
    EXPECT_TRUE(says(contents(cloud), ending == "ply" ? "\ncomment doubted: " : "\n# doubted: "));
  }
}

TEST_F(CheckProgram, PutsACycleThatHasSlippedInOrder) {
  ASSERT_EQ(run_program({"reconstruct", path("scan"), "-o", path("right.ply")}).exit_code, 0);
  rename_frames({1, 2, 3, 4, 5, 0});
  const ProgramRun run =
      run_program({"reconstruct", path("scan"), "--json", "-o", path("cloud.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(says(run.err, "frames put in the order 5,0,1,2,3,4")) << run.err;
  EXPECT_TRUE(says(run.out, "\"repairs\"")) << run.out;
  EXPECT_FALSE(says(run.out, "\"doubted\"")) << run.out;
  EXPECT_EQ(contents(path("cloud.ply")), contents(path("right.ply")));
}

TEST_F(CheckProgram, CalibrationsAndTheViewerRefuseItToo) {
  swap_frames();
  expect_one_line(run_program({"calibrate", "noise", path("scan"), path("scan")}), {path("scan")});
  const std::vector<std::string> view{"view", path("scan"), "--snapshot", path("a.png")};
  if (run_program({"view", "--help"}).exit_code != 0) GTEST_SKIP() << "built without viewer";
  expect_one_line(run_program(view), {path("scan")});
}

TEST_F(CheckProgram, ARecordingOfOtherPatternsIsKeptWithAWarning) {
  const std::string six = path("six.slip"), claimed = path("claimed.slip");
  ASSERT_EQ(run_program({"record", "--source", "virtual", "-o", six, "--camera", "160x120",
                         "--frames", "24", "--strategy", "pmp", "--steps", "6"})
                .exit_code,
            0);
  const ProgramRun run =
      run_program({"record", "--source", "replay:" + six, "-o", claimed, "--rate", "0",
                   "--strategy", "dual-frequency", "--steps", "3", "--high", "16", "--low", "1"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(says(run.err, "warning: ")) << run.err;
  EXPECT_TRUE(fs::exists(claimed));
}

TEST_F(CheckProgram, RawPicturesOfAColourCameraAreToldAndThatMostPixelsAreLost) {
  for (int n = 0; n < 6; ++n) {
    const Image<std::uint16_t> seen = read_grey_image(frame(n));
    Image<std::uint8_t> raw(seen.size());
    for (int row = 0; row < raw.height(); ++row) {
      for (int column = 0; column < raw.width(); ++column) {
        const double share = (column + row) % 2 == 1 ? 1 : 0.35;
        raw(column, row) = static_cast<std::uint8_t>(share * seen(column, row));
      }
    }
    write_image(frame(n), raw);
  }
  const ProgramRun run = run_program({"reconstruct", path("scan")});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_TRUE(says(run.err, "colour camera")) << run.err;
  EXPECT_TRUE(says(run.err, "under 50 % of the lit pixels")) << run.err;
}

TEST(CheckProgramCases, PixelsOf14BitsIn16AreTold) {
  const fs::path folder = shared_cases() / "04-14-bits-in-16";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  std::vector<std::string> command{"reconstruct", folder / "scan",
                                   "--strategy",  "dual-frequency",
                                   "--steps",     "4",
                                   "--high",      "16",
                                   "--projector", "1280x800",
                                   "--scanner",   folder / "scanner.yaml"};
  const ProgramRun run = run_program(command);
  EXPECT_TRUE(says(run.err, "--camera-bits 14")) << run.err;
  command.insert(command.end(), {"--camera-bits", "14"});
  const ProgramRun right = run_program(command);
  EXPECT_EQ(right.exit_code, 0);
  EXPECT_EQ(right.err, "");
}

}  // namespace slipstream::check_program_test
