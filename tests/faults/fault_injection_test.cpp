// Every command on a small scan while one call of the world's fails: the program ends with a code
// and a line, and what it was to write is there whole, as it was, or, where there was nothing, not
// at all; nor is memory leaked, where the leak sanitizer of the compiler is there to tell. By
// default some of the calls fail, spread evenly. SLIPSTREAM_FAULTS=100 tries about so many of each
// kind in each command, so that 1000000 are all; SLIPSTREAM_FAULTS=all every one, but of malloc, of
// each place in the code (see fault_protocol.h) that no command before has tried, the first call
// and one of those after it; SLIPSTREAM_FAULTS=@500 the 500th call alone.
// SLIPSTREAM_FAULTS_OF=malloc leaves the other kinds out.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "slipstream/io/recording.h"
#include "tests/app/program.h"
#include "tests/faults/fault_protocol.h"

#ifdef SLIPSTREAM_FAULT_LIBRARY
namespace slipstream {
namespace {
namespace fs = std::filesystem;

struct Case {
  std::string name;
  std::vector<std::string> arguments;  ///< %: the folder of the input, @: that of the output
  std::vector<std::string> outputs{};
};

const std::vector<Case> cases{
    {"simulate",
     {"simulate", "@/scan", "--camera", "16x12"},
     {"scan/scan.yaml", "scan/frame_00.png"}},
    {"simulate_recording", {"simulate", "@/frames.slip", "--camera", "16x12"}, {"frames.slip"}},
    {"reconstruct",
     {"reconstruct", "%/scan", "--anyway", "-o", "@/cloud.ply", "--mesh", "@/mesh.obj", "--depth",
      "@/depth.tiff", "--preview", "@/preview.png"},
     {"cloud.ply", "mesh.obj", "mesh.mtl", "mesh-texture.png", "depth.tiff", "preview.png"}},
    {"reconstruct_recording",
     {"reconstruct", "%/frames.slip", "--anyway", "-o", "@/cloud.pcd", "--json"},
     {"cloud.pcd"}},
    {"manifest",
     {"reconstruct", "%/scan", "--anyway", "-o", "@/cloud.ply", "--manifest", "@/done.jsonl"},
     {"cloud.ply"}},
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
    {"view",
     {"view", "%/scan", "--anyway", "--snapshot", "@/snapshot.png", "--size", "64x48"},
     {"snapshot.png"}},
    {"compare",
     {"compare", "board", "--camera", "48x36", "--strategies", "pmp, steps 3", "-o", "@/compared"},
     {"compared/rms.png", "compared/cloud-01.png"}},
    {"gamma",
     {"calibrate", "gamma", "%/gamma", "-o", "@/gamma.yaml", "--map", "@/gamma.tiff", "--histogram",
      "@/gamma.png"},
     {"gamma.yaml", "gamma.tiff", "gamma.png"}},
    {"noise", {"calibrate", "noise", "%/noise", "-o", "@/noise.yaml"}, {"noise.yaml"}},
    {"board",
     {"calibrate", "board", "--spacing", "5", "--corners", "4x3", "-o", "@/board.png"},
     {"board.png"}},
    {"patterns",
     {"patterns", "@/patterns", "--projector", "64x48", "--steps", "3"},
     {"patterns/scan.yaml", "patterns/pattern_00.png"}},
    {"design", {"design", "--steps", "4", "--noise-variance", "2"}},
    {"help", {"--help"}},
    {"refused", {"reconstruct", "%/nothing"}},
    {"geometry",
     {"calibrate", "geometry", "%/poses", "--corners", "5x4", "--spacing", "25", "-o",
      "@/scanner.yaml"},
     {"scanner.yaml"}}};

/// As FaultCall.
const std::vector<std::string> call_names{"malloc", "open",  "write", "close",
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

/// The exit code of a run that leaks.
constexpr int leaking = 99;

/// The program, loaded once and run again and again with the same arguments, as fault_library does.
class FaultedProgram {
 public:
  /// `closely`: leaks are known by all of their frames, and those of libraries passed over; slow.
  FaultedProgram(const std::vector<std::string>& arguments, bool closely) {
    const fs::path record = folder_.path() / "record";
    std::ofstream(record) << "";
    fs::resize_file(record, sizeof(FaultRecord));
    const int file = ::open(record.c_str(), O_RDWR | O_CLOEXEC);
    void* const memory =
        ::mmap(nullptr, sizeof(FaultRecord), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    ::close(file);
    if (memory == MAP_FAILED) throw std::runtime_error("no memory for what is recorded");
    record_ = static_cast<FaultRecord*>(memory);
    for (const char* pipe : {"requests", "answers"}) {
      ::mkfifo((folder_.path() / pipe).c_str(), 0600);
    }
    const fs::path passed_over = folder_.path() / "leaks",
                   tests = SLIPSTREAM_SOURCE_FOLDER "/tests";
    std::ofstream(passed_over) << contents(tests / "opengl/driver_leaks.txt")
                               << contents(tests / "faults/library_leaks.txt");
    ::setenv("LD_PRELOAD", SLIPSTREAM_FAULT_LIBRARY " " SLIPSTREAM_LEAK_LIBRARY, 1);
    ::setenv("LSAN_OPTIONS",
             ("exitcode=99:print_suppressions=0:suppressions=" + passed_over.string() +
              (closely ? ":fast_unwind_on_malloc=0" : ""))
                 .c_str(),
             1);
    ::setenv("SLIPSTREAM_FAULTS_FROM", folder_.path().c_str(), 1);
    program_.emplace(arguments);
    ::unsetenv("LD_PRELOAD");
    requests_ = ::open((folder_.path() / "requests").c_str(), O_WRONLY | O_CLOEXEC);
    answers_ = ::open((folder_.path() / "answers").c_str(), O_RDONLY | O_CLOEXEC);
  }
  FaultedProgram(const FaultedProgram&) = delete;
  FaultedProgram& operator=(const FaultedProgram&) = delete;
  ~FaultedProgram() {
    ::close(requests_);  // it ends
    ::close(answers_);
    ::munmap(record_, sizeof(FaultRecord));
  }

  /// The exit code, or what signal ended it, negative; SIGALRM where it hangs.
  int run(FaultRequest request) {
    record_->faults = record_->place = 0;
    for (auto& calls : record_->calls) calls = 0;
    (void)!::write(requests_, &request, sizeof request);
    pollfd answered{answers_, POLLIN, 0};
    const bool hangs = ::poll(&answered, 1, 60000) == 0;
    if (hangs) ::kill(record_->process, SIGKILL);
    int status = 0;
    if (::read(answers_, &status, sizeof status) != sizeof status) return -SIGPIPE;
    return hangs ? -SIGALRM : WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  [[nodiscard]] const FaultRecord& record() const { return *record_; }
  [[nodiscard]] std::string err() const { return program_->err(); }

 private:
  TemporaryFolder folder_;
  FaultRecord* record_ = nullptr;
  std::optional<RunningProgram> program_;
  int requests_ = -1, answers_ = -1;
};

/// Places in the code whose failure has been tried, by whatever command.
std::set<std::uint64_t> tried_places;

/// Of each place not tried yet the first call, and one of those after it.
std::vector<std::uint64_t> calls_of_new_places(const FaultRecord& record) {
  std::map<std::uint64_t, std::vector<std::uint64_t>> calls;
  const std::uint64_t count = std::min<std::uint64_t>(record.calls[of_malloc], most_places);
  for (std::uint64_t i = 0; i < count; ++i) {
    if (!tried_places.contains(record.places[i])) calls[record.places[i]].push_back(i + 1);
  }
  std::mt19937 random(18);
  std::vector<std::uint64_t> chosen;
  for (const auto& [place, all] : calls) {
    tried_places.insert(place);
    chosen.push_back(all.front());
    if (all.size() > 1) chosen.push_back(all[1 + random() % (all.size() - 1)]);
  }
  return chosen;
}

/// Calls to be made to fail, of those of a run without a fault.
std::vector<std::uint64_t> calls_to_fail(FaultCall call, const FaultRecord& whole) {
  const char* const of = std::getenv("SLIPSTREAM_FAULTS_OF");
  if (of != nullptr && call_names[call] != of) return {};
  const char* const asked = std::getenv("SLIPSTREAM_FAULTS");
  const std::string wanted = asked == nullptr ? "3" : asked;
  if (wanted.starts_with('@')) return {std::stoull(wanted.substr(1))};
  if (call == of_malloc && wanted == "all") return calls_of_new_places(whole);
  const std::uint64_t all = whole.calls[call];
  const std::uint64_t most = wanted == "all" ? all : std::stoull(wanted);
  std::vector<std::uint64_t> chosen;
  for (std::uint64_t at = 1; at <= all;
       at += most < 2 ? all : std::max<std::uint64_t>(1, all / most)) {
    chosen.push_back(at);
  }
  return chosen;
}

class FaultInjection : public testing::TestWithParam<Case> {
 public:
  static void SetUpTestSuite() { input_ = std::make_unique<TemporaryFolder>(); }
  static void TearDownTestSuite() { input_.reset(); }

 protected:
  /// The inputs that the command takes are made where they are not there yet.
  void SetUp() override {
    require("scan", {"simulate", "--camera", "64x48"});
    require("frames.slip", {"simulate", "--camera", "64x48"});
    require("noise", {"simulate", "--camera", "64x48", "--strategy", "pmp", "--steps", "4"});
    require("gamma", {"simulate", "--camera", "64x48", "--strategy", "pmp", "--steps", "8",
                      "--scene", "board"});
    require("poses", {"simulate", "--boards", "4", "--corners", "5x4", "--spacing", "25",
                      "--camera", "160x120", "--world", "ideal", "--steps", "3"});
  }
  static void require(const std::string& name, std::vector<std::string> arguments) {
    const auto& words = GetParam().arguments;
    if (fs::exists(input_->path() / name) ||
        std::none_of(words.begin(), words.end(),
                     [&](const std::string& word) { return word.ends_with("%/" + name); }))
      return;
    arguments.push_back(input_->path() / name);
    const ProgramRun run = run_program(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  struct Outcome {
    int code = 0;
    std::string err;
    std::map<std::string, std::string> written{};  ///< of the outputs that are there
    std::vector<std::string> left{};               ///< temporary files
  };

  /// Whether the output is there before; folders that are to be made are not, nor files in them,
  /// nor a scanner file, which would be read and added to.
  static bool is_old(const std::string& name, bool old) {
    return old && name.find('/') == std::string::npos && name != "scanner.yaml";
  }

  [[nodiscard]] fs::path output() const { return folder_.path() / "out"; }

  [[nodiscard]] std::vector<std::string> arguments() const {
    std::vector<std::string> arguments;
    for (const std::string& word : GetParam().arguments) {
      arguments.push_back(replaced(replaced(word, '%', input_->path()), '@', output()));
    }
    return arguments;
  }

  /// `old`: outputs hold something before.
  Outcome run(FaultedProgram& program, FaultRequest request, bool old) const {
    fs::remove_all(output());
    fs::create_directory(output());
    for (const std::string& name : GetParam().outputs) {
      if (is_old(name, old)) std::ofstream(output() / name) << "old";
    }
    Outcome outcome{program.run(request), program.err()};
    for (const std::string& name : GetParam().outputs) {
      if (fs::exists(output() / name)) outcome.written[name] = essence(output() / name);
    }
    for (const auto& entry : fs::recursive_directory_iterator(output())) {
      if (entry.path().extension() == ".part") outcome.left.push_back(entry.path().string());
    }
    return outcome;
  }

  /// Why the outcome is not one that is promised; empty where it is.
  static std::string broken_promise(const Outcome& outcome, const Outcome& whole, bool old) {
    if (outcome.code == leaking) return "leaks";
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
      const bool was_there = is_old(name, old);
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
  TemporaryFolder folder_;
};

std::unique_ptr<TemporaryFolder> FaultInjection::input_;

TEST_P(FaultInjection, EndsAsPromised) {
  FaultedProgram program(arguments(), false);
  std::optional<FaultedProgram> close;
  const Outcome whole = run(program, {}, false);
  ASSERT_LE(whole.code, 2) << whole.err;
  ASSERT_GE(whole.code, 0) << whole.err;
  ASSERT_EQ(whole.written.size(), GetParam().outputs.size()) << whole.err;
  // Before a file has its name it is on the disk, and after that its folder.
  EXPECT_GE(program.record().calls[of_fsync], 2 * program.record().calls[of_rename]);
  std::vector<FaultRequest> faults;
  std::array<std::uint64_t, fault_calls> calls{}, tried{}, kept{};
  for (std::uint64_t i = 0; i < fault_calls; ++i) {
    const auto call = static_cast<FaultCall>(i);
    calls[call] = program.record().calls[call];
    for (const std::uint64_t at : calls_to_fail(call, program.record()))
      faults.push_back({call, at});
  }
  for (const auto [call, at] : faults) {
    const bool old = tried[call] % 2 == 0;
    Outcome outcome = run(program, {call, at}, old);
    if (program.record().faults == 0) continue;  // threads do not call as often each time
    if (outcome.code == leaking) {
      if (!close) close.emplace(arguments(), true);
      outcome = run(*close, {call, at}, old);
    }
    ++tried[call];
    const std::string broken = broken_promise(outcome, whole, old);
    kept[call] += broken.empty() ? 1 : 0;
    EXPECT_EQ(broken, "") << call_names[call] << " " << at << " of " << calls[call]
                          << ", exit code " << outcome.code << ": " << outcome.err;
  }
  for (std::uint64_t call = 0; call < fault_calls; ++call) {
    std::cout << GetParam().name << ": " << call_names[call] << ": " << calls[call] << " calls, "
              << tried[call] << " failed, " << kept[call] << " as promised\n";
  }
}

INSTANTIATE_TEST_SUITE_P(Command, FaultInjection, testing::ValuesIn(cases),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace slipstream
#endif
