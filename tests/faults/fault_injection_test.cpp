// Every command on a small scan while one call of the world's fails: the program ends with a code
// and a line, and what it was to write is there whole, as it was, or, where there was nothing, not
// at all. By default some of the calls fail, spread evenly; SLIPSTREAM_FAULTS=all tries every one,
// or SLIPSTREAM_FAULTS=100 about so many of each kind in each command. SLIPSTREAM_FAULTS_OF=malloc
// leaves the other kinds out.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>

#include "slipstream/io/recording.h"
#include "tests/app/program.h"

#ifdef SLIPSTREAM_FAULT_LIBRARY
namespace slipstream {
namespace {
namespace fs = std::filesystem;
using namespace std::chrono_literals;

struct Case {
  std::string name;
  std::vector<std::string> arguments;  ///< %: the folder of the input, @: that of the output
  std::vector<std::string> outputs{};
};

const std::vector<Case> cases{
    {"simulate",
     {"simulate", "@/scan", "--camera", "64x48"},
     {"scan/scan.yaml", "scan/frame_00.png"}},
    {"simulate_recording", {"simulate", "@/frames.slip", "--camera", "64x48"}, {"frames.slip"}},
    {"reconstruct",
     {"reconstruct", "%/scan", "--anyway", "-o", "@/cloud.ply", "--mesh", "@/mesh.obj", "--depth",
      "@/depth.tiff", "--preview", "@/preview.png"},
     {"cloud.ply", "mesh.obj", "mesh.mtl", "mesh-texture.png", "depth.tiff", "preview.png"}},
    {"reconstruct_recording",
     {"reconstruct", "%/frames.slip", "--anyway", "-o", "@/cloud.pcd", "--json"},
     {"cloud.pcd"}},
    {"check", {"check", "%/scan"}},
    {"measure", {"measure", "%/scan", "--anyway", "--point", "32,24"}},
    {"record",
     {"record", "--source", "replay:%/frames.slip", "--rate", "0", "-o", "@/new.slip"},
     {"new.slip"}},
    {"live",
     {"live", "--source", "replay:%/frames.slip", "--rate", "0", "--headless", "-o", "@/live.ply",
      "--record", "@/live.slip"},
     {"live.ply", "live.slip"}},
    {"capture",
     {"capture", "--source", "replay:%/frames.slip", "--rate", "0", "-o", "@/taken"},
     {"taken/scan.yaml"}},
    {"noise", {"calibrate", "noise", "%/noise", "-o", "@/noise.yaml"}, {"noise.yaml"}},
    {"board",
     {"calibrate", "board", "--spacing", "5", "--corners", "4x3", "-o", "@/board.png"},
     {"board.png"}},
    {"patterns",
     {"patterns", "@/patterns", "--projector", "64x48", "--steps", "3"},
     {"patterns/scan.yaml", "patterns/pattern_00.png"}},
    {"design", {"design", "--steps", "4"}},
    {"help", {"--help"}},
    {"refused", {"reconstruct", "%/nothing"}}};

const std::vector<std::string> calls{"malloc", "open",  "write", "close",
                                     "rename", "fsync", "thread"};

void PrintTo(const Case& tried, std::ostream* stream) {
  *stream << tried.name;
}

std::string replaced(std::string text, char mark, const fs::path& folder) {
  const std::size_t at = text.find(mark);
  return at == std::string::npos ? text : text.replace(at, 1, folder.string());
}

/// What a recording holds, without the times at which frames came; else the bytes.
std::string essence(const fs::path& path) {
  if (path.extension() != ".slip" || !is_recording(path)) return contents(path);
  const RecordingReader recording(path);
  std::string frames;
  Frame frame;
  for (std::uint64_t i = 0; i < recording.count(); ++i) {
    if (!recording.read(i, frame)) return "damaged";
    const auto& image = std::get<0>(frame.pixels);
    frames.append(image.begin(), image.end());
  }
  return frames;
}

class FaultInjection : public testing::TestWithParam<Case> {
 public:
  static void SetUpTestSuite() {
    input_ = std::make_unique<TemporaryFolder>();
    const auto make = [](const std::vector<std::string>& arguments) {
      const ProgramRun run = run_program(arguments);
      ASSERT_EQ(run.exit_code, 0) << run.err;
    };
    make({"simulate", (input_->path() / "scan").string(), "--camera", "64x48"});
    make({"simulate", (input_->path() / "frames.slip").string(), "--camera", "64x48"});
    make({"simulate", (input_->path() / "noise").string(), "--camera", "64x48", "--strategy", "pmp",
          "--steps", "4"});
  }
  static void TearDownTestSuite() { input_.reset(); }

 protected:
  struct Outcome {
    int code = 0;
    std::string err;
    std::uint64_t faults = 0;
    std::array<std::uint64_t, 7> calls{};          ///< of each kind
    std::map<std::string, std::string> written{};  ///< of the outputs that are there
    std::vector<std::string> left{};               ///< temporary files
  };

  /// `at` 0: no call fails. `old`: what the outputs hold before.
  static Outcome run(std::size_t call, std::uint64_t at, bool old) {
    const TemporaryFolder folder;
    const fs::path told = folder.path() / "told", output = folder.path() / "out";
    std::ofstream(told) << std::string(64, '\0');
    fs::create_directory(output);
    for (const std::string& name : GetParam().outputs) {
      // Folders that are to be made are not there; files in them neither.
      if (old && name.find('/') == std::string::npos) std::ofstream(output / name) << "old";
    }
    std::vector<std::string> arguments;
    for (const std::string& word : GetParam().arguments) {
      arguments.push_back(replaced(replaced(word, '%', input_->path()), '@', output));
    }
    ::setenv("LD_PRELOAD", SLIPSTREAM_FAULT_LIBRARY, 1);
    ::setenv("SLIPSTREAM_FAULT", std::to_string(call).c_str(), 1);
    ::setenv("SLIPSTREAM_FAULT_AT", std::to_string(at).c_str(), 1);
    ::setenv("SLIPSTREAM_FAULT_TOLD", told.c_str(), 1);
    RunningProgram program(arguments);
    ::unsetenv("LD_PRELOAD");
    siginfo_t ended{};
    for (int tries = 0; tries < 6000 && ended.si_pid == 0; ++tries) {
      std::this_thread::sleep_for(5ms);
      ::waitid(P_PID, static_cast<id_t>(program.process()), &ended, WEXITED | WNOHANG | WNOWAIT);
    }
    Outcome outcome;
    if (ended.si_pid == 0) {
      outcome.code = -SIGALRM;  // it hangs
    } else {
      outcome.code = program.wait();
    }
    outcome.err = program.err();
    const std::string numbers = contents(told);
    std::memcpy(&outcome.faults, numbers.data(), 8);
    std::memcpy(outcome.calls.data(), numbers.data() + 8, 56);
    for (const std::string& name : GetParam().outputs) {
      if (fs::exists(output / name)) outcome.written[name] = essence(output / name);
    }
    for (const auto& entry : fs::recursive_directory_iterator(output)) {
      if (entry.path().extension() == ".part") outcome.left.push_back(entry.path().string());
    }
    return outcome;
  }

  /// Why the outcome is not one that is promised; empty where it is.
  static std::string broken_promise(const Outcome& outcome, const Outcome& whole, bool old) {
    if (outcome.code < 0 || outcome.code > 2) return "ended by " + std::to_string(-outcome.code);
    if (outcome.code != 0 && outcome.err.find("slipstream: ") == std::string::npos) {
      return "says nothing of it";
    }
    if (outcome.err.find("terminate called") != std::string::npos) return "terminates";
    for (const std::string& name : outcome.left) {
      if (outcome.err.find(name) == std::string::npos) return name + " is left";
    }
    for (const std::string& name : GetParam().outputs) {
      const auto found = outcome.written.find(name);
      const bool was_there = old && name.find('/') == std::string::npos;
      if (found == outcome.written.end()) {
        if (was_there) return name + " is lost";
        if (outcome.code == 0) return name + " is missing";
        continue;
      }
      const std::string &is = found->second, &should = whole.written.at(name);
      if (is == should || (outcome.code != 0 && was_there && is == "old")) continue;
      // A recording that fails keeps the frames before.
      const bool begun = name.ends_with(".slip") && outcome.code != 0 && should.starts_with(is);
      if (!begun) return name + " is neither old nor whole";
    }
    return "";
  }

  static std::unique_ptr<TemporaryFolder> input_;
};

std::unique_ptr<TemporaryFolder> FaultInjection::input_;

TEST_P(FaultInjection, EndsAsPromised) {
  const char* const asked = std::getenv("SLIPSTREAM_FAULTS");
  const std::string wanted = asked == nullptr ? "3" : asked;
  const char* const of = std::getenv("SLIPSTREAM_FAULTS_OF");
  const Outcome whole = run(0, 0, false);
  ASSERT_LE(whole.code, 2) << whole.err;
  ASSERT_GE(whole.code, 0) << whole.err;
  ASSERT_EQ(whole.written.size(), GetParam().outputs.size()) << whole.err;
  for (std::size_t call = 0; call < calls.size(); ++call) {
    if (of != nullptr && calls[call] != of) continue;
    const std::uint64_t all = whole.calls[call];
    const std::uint64_t most = wanted == "all" ? all : std::stoull(wanted);
    const std::uint64_t stride = most == 0 ? 1 : std::max<std::uint64_t>(1, all / most);
    int tried = 0, kept = 0;
    for (std::uint64_t at = 1; at <= all; at += stride) {
      const bool old = tried % 2 == 0;
      const Outcome outcome = run(call, at, old);
      if (outcome.faults == 0) continue;  // threads do not call as often each time
      ++tried;
      const std::string broken = broken_promise(outcome, whole, old);
      kept += broken.empty() ? 1 : 0;
      EXPECT_EQ(broken, "") << calls[call] << " " << at << " of " << all << ", exit code "
                            << outcome.code << ": " << outcome.err;
    }
    std::cout << GetParam().name << ": " << calls[call] << ": " << all << " calls, " << tried
              << " failed, " << kept << " as promised\n";
  }
}

INSTANTIATE_TEST_SUITE_P(Command, FaultInjection, testing::ValuesIn(cases),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace slipstream
#endif
