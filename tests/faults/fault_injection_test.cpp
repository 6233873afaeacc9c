// Every command on a small scan while one call of the world's fails, or with few file descriptors:
// the program ends with a code and a line, and what it was to write is there whole, as it was, or,
// where there was nothing, not at all; nor is memory leaked, where the leak sanitizer of the
// compiler is there to tell. By default some of the calls fail, spread evenly.
// SLIPSTREAM_FAULTS=100 tries about so many of each kind in each command, so that 1000000 are all;
// SLIPSTREAM_FAULTS=all every one, but of malloc, of each place in the code (see fault_protocol.h)
// that no command before has tried, the first call and one of those after it;
// SLIPSTREAM_FAULTS=@500 the 500th call alone. SLIPSTREAM_FAULTS_OF=malloc leaves the other kinds
// out.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "publish/mcap.h"
#include "publish/mcap_reader.h"
#include "slipstream/error.h"
#include "slipstream/recording.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/faults/commands.h"
#include "tests/faults/faulted_program.h"

#ifdef SLIPSTREAM_FAULT_LIBRARY
namespace slipstream::fault_injection_test {
namespace fs = std::filesystem;

/// As FaultCall.
const std::vector<std::string> call_names{"malloc", "open",  "write", "close",
                                          "rename", "fsync", "thread"};

std::string replaced(std::string text, char mark, const fs::path& folder) {
  const std::size_t at = text.find(mark);
  return at == std::string::npos ? text : text.replace(at, 1, folder.string());
}

/// The pictures and points of an MCAP file, in their order.
std::string essence_of_mcap(const fs::path& path) {
  constexpr std::size_t time = 12;  // with what says how a message is coded
  std::string messages;
  try {
    const bool ended = read_mcap(path, [&](const McapMessage& message) {
      if (message.encoding.empty() || message.topic == "/statistics") return;
      messages.append(message.content.begin() + time, message.content.end());
    });
    return messages + (ended ? "." : "");
  } catch (const Error&) {
    return "damaged";
  }
}

/// The scans of a plan, without what they cost: one that cannot be read costs little.
std::string essence_of_plan(const fs::path& path) {
  std::istringstream lines(contents(path));
  std::string scans;
  for (std::string line; std::getline(lines, line);)
    scans += line.substr(0, line.find('\t')) + '\n';
  return scans;
}

/// What a recording holds, without the times at which frames came; else the bytes.
std::string essence(const fs::path& path) {
  if (path.filename() == "scans.txt") return essence_of_plan(path);
  if (path.extension() == ".mcap" && contents(path) != "old") return essence_of_mcap(path);
  if (path.extension() != ".slip" || !is_recording(path)) return contents(path);
  const RecordingReader recording(path);
  std::string frames;
  Frame frame;
  for (std::uint64_t i = 0; i < recording.count(); ++i) {
    if (!recording.read(i, frame)) return "damaged";
    const auto& image = std::get<0>(frame.pixels);
    frames.append(image.begin(), image.end());
  }
  return frames + (recording.finished() ? "." : "");
}

/// The exit code of a run that leaks.
constexpr int leaking = 99;

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
  const std::string wanted = asked == nullptr ? "2" : asked;
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
  /// The inputs that the command takes are made, and what is to be there before.
  void SetUp() override {
    make_inputs(GetParam().arguments);
    for (const std::vector<std::string>& words : GetParam().before) {
      fs::create_directories(output());
      make_inputs(words);
      run_whole(placed(words));
    }
    if (fs::exists(output())) fs::rename(output(), before());
  }

  static void run_whole(const std::vector<std::string>& arguments) {
    const ProgramRun run = run_program(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  void make_inputs(const std::vector<std::string>& words) const {
    for (const std::string& word : words) {
      const std::size_t at = word.find("%/");
      if (at == std::string::npos) continue;
      if (const std::string name = word.substr(at + 2); !fs::exists(input_->path() / name)) {
        make_input(name);
      }
    }
  }

  void make_input(const std::string& name) const {
    const fs::path path = input_->path() / name;
    if (name == "rig.yaml") std::ofstream(path) << "rate: 0\n";
    if (name == "artefacts.yaml") {
      make_inputs({"%/plane_0", "%/plane_20"});
      std::ofstream(path) << "planes: [plane_0, plane_20]\ndiagonal: 400\n";
    }
    if (name == "knocked.yaml") {
      make_inputs({"%/poses"});
      Scanner scanner = read_scanner(input_->path() / "poses/scanner.yaml");
      scanner.rotation = Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX()) * scanner.rotation;
      write_scanner(path, scanner);
    }
    const auto made = inputs.find(name);
    if (made == inputs.end()) return;
    make_inputs(made->second);
    std::vector<std::string> arguments = placed(made->second);
    arguments.push_back(path);
    run_whole(arguments);
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

  /// What is there before a run; not each command wants anything.
  [[nodiscard]] fs::path before() const { return folder_.path() / "before"; }

  /// The words with their folders.
  [[nodiscard]] std::vector<std::string> placed(std::vector<std::string> words) const {
    for (std::string& word : words) {
      word = replaced(replaced(word, '%', input_->path()), '@', output());
    }
    return words;
  }

  /// `old`: outputs hold something before.
  void lay_out(bool old) const {
    fs::remove_all(output());
    fs::create_directory(output());
    if (fs::exists(before())) fs::copy(before(), output(), fs::copy_options::recursive);
    for (const std::string& name : GetParam().outputs) {
      if (is_old(name, old)) std::ofstream(output() / name) << "old";
    }
  }

  Outcome run(FaultedProgram& program, FaultRequest request, bool old) const {
    lay_out(old);
    return run_over(program, request);
  }

  /// Over what the run before left.
  Outcome run_over(FaultedProgram& program, FaultRequest request) const {
    const int code = program.run(request);
    return outcome_of(code, program.err());
  }

  /// With at most so many open files; negative: as many as it wants.
  Outcome run_with(int descriptors, bool old) const {
    lay_out(old);
    const ProgramRun run = run_program(placed(GetParam().arguments), -1, descriptors);
    return outcome_of(run.exit_code, run.err);
  }

  [[nodiscard]] Outcome outcome_of(int code, const std::string& err) const {
    Outcome outcome{code, err};
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
      // A recording that fails keeps the frames before; with none it is not there.
      const std::string before = is.ends_with('.') ? is.substr(0, is.size() - 1) : is;
      const bool begun =
          GetParam().grows && outcome.code != 0 && !before.empty() && should.starts_with(before);
      if (!begun) return name + " is neither old nor whole";
    }
    return "";
  }

  static std::unique_ptr<TemporaryFolder> input_;
  TemporaryFolder folder_;
};

std::unique_ptr<TemporaryFolder> FaultInjection::input_;

TEST_P(FaultInjection, EndsAsPromised) {
  FaultedProgram program(placed(GetParam().arguments), false);
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
      if (!close) close.emplace(placed(GetParam().arguments), true);
      outcome = run(*close, {call, at}, old);
    }
    ++tried[call];
    std::string broken = broken_promise(outcome, whole, old);
    if (GetParam().resumes && broken.empty() && outcome.code != 0) {
      outcome = run_over(program, {});
      broken = outcome.code == 0 ? broken_promise(outcome, whole, false) : "does not resume";
    }
    kept[call] += broken.empty() ? 1 : 0;
    EXPECT_EQ(broken, "") << call_names[call] << " " << at << " of " << calls[call]
                          << ", exit code " << outcome.code << ": " << outcome.err;
  }
  for (std::uint64_t call = 0; call < fault_calls; ++call) {
    std::cout << GetParam().name << ": " << call_names[call] << ": " << calls[call] << " calls, "
              << tried[call] << " failed, " << kept[call] << " as promised\n";
  }
}

TEST_P(FaultInjection, EndsAsPromisedWithFewDescriptors) {
  const Outcome whole = run_with(-1, false);
  ASSERT_EQ(whole.written.size(), GetParam().outputs.size()) << whole.err;

  for (const int descriptors : {3, 4, 5, 6, 7, 8, 10, 12, 15, 20, 30}) {
    const bool old = descriptors % 2 == 0;
    const Outcome outcome = run_with(descriptors, old);

    // Then not a line of the program has run.
    if (outcome.err.find("error while loading shared libraries") != std::string::npos) continue;
    EXPECT_EQ(broken_promise(outcome, whole, old), "")
        << descriptors << " descriptors, exit code " << outcome.code << ": " << outcome.err;
  }
}

std::vector<Case> chosen_cases() {
  std::vector<Case> chosen = cases;
  if (std::getenv("SLIPSTREAM_FAULTS") == nullptr) {
    std::erase_if(chosen, [](const Case& one) { return one.when_asked; });
  }
  return chosen;
}

INSTANTIATE_TEST_SUITE_P(Command, FaultInjection, testing::ValuesIn(chosen_cases()),
                         [](const auto& info) { return info.param.name; });

}  // namespace slipstream::fault_injection_test
#endif
