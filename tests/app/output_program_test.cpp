// Every flag that names an output, with every kind of target.
#include <filesystem>
#include <fstream>
#include <memory>
#include <ostream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::output_program_test {
namespace fs = std::filesystem;
using Words = std::vector<std::string>;

/// A flag that writes. In the command % is the folder of the inputs, @ that of the outputs.
struct WritingFlag {
  std::string flag;     ///< a name without dashes: an argument
  std::string name;     ///< of the output, with an ending that the flag writes
  Words command;        ///< without the flag
  Words more{};         ///< behind the flag
  std::string begin{};  ///< of the flag's value, before the path
};

void PrintTo(const WritingFlag& flag, std::ostream* stream) {
  *stream << flag.command.front() << ' ' << flag.flag << ' ' << flag.name;
}

Words reconstruct(const std::string& scan) {
  return {"reconstruct", "%/" + scan, "--anyway"};
}

const Words live_replay{"live", "--source", "replay:%/frames.slip", "--rate", "0", "--headless"};
const Words unwrapping{"unwrap", "%/wrapped.tiff"},
    heights{"height", "%/plane_20", "--calibration", "%/heights.npy", "--anyway"};

/// Flags of files whose commands run here, in a moment.
const std::vector<WritingFlag> file_flags{
    {"-o", "cloud.ply", reconstruct("scan")},
    {"--mesh", "mesh.ply", reconstruct("scan")},
    {"--mesh", "mesh.obj", reconstruct("scan")},
    {"--depth", "depth.tiff", reconstruct("scan")},
    {"--coordinate", "coordinate.npy", reconstruct("scan")},
    {"--phase", "phase.tiff", reconstruct("scan")},
    {"--modulation", "modulation.tiff", reconstruct("scan")},
    {"--mean", "mean.tiff", reconstruct("scan")},
    {"--epipolar", "epipolar.tiff", reconstruct("both")},
    {"--motion-map", "motion.tiff", reconstruct("moving")},
    {"--reflection-map", "reflection.tiff", reconstruct("scan"), {"--reflection", "5"}},
    {"--preview", "preview.png", reconstruct("scan")},
    {"-o", "live.pcd", live_replay},
    {"--record", "live.slip", live_replay},
    {"--snapshot", "snapshot.png", live_replay, {"--size", "64x48"}},
    {"--screenshot", "screenshot.png", live_replay, {"--size", "64x48"}},
    {"--publish", "live.mcap", live_replay, {}, "mcap:"},
    {"-o", "new.slip", {"record", "--source", "replay:%/frames.slip", "--rate", "0"}},
    {"-o", "cloud.xyz", {"convert", "%/cloud.ply"}},
    {"-o", "clouds.mcap", {"convert", "%/cloud.ply"}},
    {"-o", "frames.slip", {"convert", "%/scan"}},
    {"-o", "phase.npy", unwrapping},
    {"--regions", "regions.tiff", unwrapping, {"-o", "@/phase.npy"}},
    {"--preview", "phase.png", unwrapping, {"-o", "@/phase.npy"}},
    {"-o", "height.tiff", heights},
    {"--preview", "height.png", heights, {"-o", "@/height.tiff"}},
    {"-o",
     "heights.npy",
     {"calibrate", "height", "%/plane_0", "%/plane_20", "%/plane_40", "--heights", "0,20,40",
      "--anyway"}},
    {"--map", "gamma.tiff", {"calibrate", "gamma", "%/gamma"}},
    {"-o", "ambient.yaml", {"calibrate", "ambient", "%/gamma"}},
    {"--histogram", "ambient.png", {"calibrate", "ambient", "%/gamma"}},
    {"-o", "colour.yaml", {"calibrate", "colour", "%/white"}},
    {"-o", "noise.yaml", {"calibrate", "noise", "%/plane_0"}},
    {"-o", "board.pdf", {"calibrate", "board", "--spacing", "5", "--corners", "4x3"}},
    {"--sheet", "sheet.png", {"patterns", "@/patterns", "--projector", "64x48", "--steps", "3"}},
    {"--plot", "plot.png", {"design", "--steps", "4", "--noise-variance", "2"}},
    {"folder", "scan.slip", {"simulate"}, {"--camera", "16x12"}}};

/// Flags of files whose commands need a camera, a window, minutes or an earlier output, so that
/// only refusals before any work are tested.
const std::vector<WritingFlag> idle_flags{
    {"--model", "model.ply", live_replay},
    {"--screenshot", "guide.png", {"capture", "--source", "virtual", "-o", "@/scan"}},
    {"-o", "scan.slip", {"capture", "--source", "virtual"}},
    {"-o",
     "scanner.yaml",
     {"calibrate", "geometry", "%/poses", "--corners", "5x4", "--spacing", "25"}},
    {"-o",
     "scanner.yaml",
     {"calibrate", "verify", "%/poses", "--corners", "5x4", "--spacing", "25", "--scanner",
      "%/scan/scanner.yaml"}},
    {"--save-points",
     "points.csv",
     {"calibrate", "geometry", "%/poses", "--corners", "5x4", "--spacing", "25", "-o", "@/a.yaml"}},
    {"--picture", "residual.png", {"calibrate", "residual", "%/both", "-o", "@/a.yaml"}},
    {"--rings",
     "rings.png",
     {"calibrate", "projection", "%/hand_eye.yaml", "--touched", "%/robot.csv", "--tip", "0,0,100",
      "--robot-convention", "ur", "--boards", "%/poses", "--scanner", "%/scan/scanner.yaml",
      "--corners", "5x4", "--spacing", "25"}},
    {"--poses", "poses.txt", {"merge", "%/a.ply", "%/b.ply", "-o", "@/model.ply"}},
    {"--log", "log.csv", {"project"}},
    {"--write-scanner", "scanner.yaml", {"camera", "serve"}},
    {"--manifest", "done.jsonl", {"reconstruct", "%/scan", "--anyway", "-o", "@/{name}.ply"}},
    {"--report", "report.html", {"reproduce", "table-2.1"}}};

/// Flags of folders. `simulate --boards` and the like write as these do.
const std::vector<WritingFlag> folder_flags{
    {"folder", "scan", {"simulate"}, {"--camera", "16x12"}},
    {"folder", "patterns", {"patterns"}, {"--projector", "64x48", "--steps", "3"}},
    {"-o", "taken", {"capture", "--source", "replay:%/frames.slip", "--rate", "0"}},
    {"-o", "folder", {"convert", "%/frames.slip"}},
    {"-o", "compared", {"compare", "board", "--camera", "48x36", "--strategies", "pmp, steps 3"}},
    {"--plots", "plots", {"reproduce", "figure-3.5"}},
    {"--plan", "plan", {"batch", "plan", "%/scan", "--tasks", "1", "-o", "x.ply"}}};

/// Flags of folders that are tested only with `-`, as their commands take seconds.
const std::vector<WritingFlag> slow_folder_flags{{"folder", "demo", {"demo"}},
                                                 {"-o", "report", {"verify", "%/artefacts.yaml"}},
                                                 {"--report",
                                                  "report",
                                                  {"calibrate", "geometry", "%/poses", "--corners",
                                                   "5x4", "--spacing", "25", "-o", "@/a.yaml"}}};

std::vector<WritingFlag> joined(std::vector<WritingFlag> some,
                                const std::vector<WritingFlag>& others) {
  some.insert(some.end(), others.begin(), others.end());
  return some;
}

/// One flag and a folder for its output.
class WritesOutput : public testing::TestWithParam<WritingFlag> {
 public:
  static void SetUpTestSuite() { inputs_ = std::make_unique<TemporaryFolder>(); }
  static void TearDownTestSuite() { inputs_.reset(); }

 protected:
  [[nodiscard]] fs::path folder() const { return outputs_.path(); }
  [[nodiscard]] fs::path target() const { return folder() / GetParam().name; }

  static Words with_inputs(Words words) {
    for (std::string& word : words) replace(word, '%', inputs_->path());
    return words;
  }

  /// Runs the command with this output.
  [[nodiscard]] ProgramRun write_to(const std::string& output) const {
    const WritingFlag& writing = GetParam();
    Words flag{writing.begin + output};
    if (writing.flag.starts_with('-')) flag.insert(flag.begin(), writing.flag);
    return run_with(flag);
  }

  /// Runs the command with these words, without its output.
  [[nodiscard]] ProgramRun run_with(const Words& flag) const {
    const WritingFlag& writing = GetParam();
    Words words = writing.command;
    words.insert(words.end(), flag.begin(), flag.end());
    words.insert(words.end(), writing.more.begin(), writing.more.end());

    for (std::string& word : words) replace(word, '@', folder());
    return run_program(with_inputs(words));
  }

  /// Expects a message in one line, after warnings about the scan.
  static void expect_failed(const ProgramRun& run, const std::string& part) {
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err << "lacks: " << part;

    std::istringstream lines(run.err);
    int failures = 0;
    for (std::string line; std::getline(lines, line);) {
      failures += line.starts_with("slipstream: ") ? 1 : 0;
    }
    EXPECT_EQ(failures, 1) << run.err;
  }

  static void expect_failed(const ProgramRun& run, int exit_code, const std::string& part) {
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    expect_failed(run, part);
  }

  /// A cloud goes to standard output; other outputs cannot, and no file is called "-".
  void expect_no_file_called_dash() const {
    const WritingFlag& writing = GetParam();
    const std::string& command = writing.command.front();
    const bool prints = writing.flag == "-o" && (command == "reconstruct" || command == "live");

    const ProgramRun run = write_to("-");
    if (prints) {
      EXPECT_EQ(run.exit_code, 0) << run.err;
      EXPECT_TRUE(run.out.starts_with("ply\n")) << run.out.substr(0, 100);
    } else {
      expect_failed(run, 2, "standard output");
    }
    EXPECT_FALSE(fs::exists("-"));
  }

 private:
  static void replace(std::string& word, char mark, const fs::path& with) {
    const std::size_t at = word.find(mark);
    if (at != std::string::npos) word.replace(at, 1, with.string());
  }

  static inline std::unique_ptr<TemporaryFolder> inputs_;
  TemporaryFolder outputs_;
};

/// With the inputs of all commands.
class WritesResults : public WritesOutput {
 public:
  static void SetUpTestSuite() {
    WritesOutput::SetUpTestSuite();
    simulate("scan", {});
    simulate("frames.slip", {});
    simulate("both", {"--axis", "both"});
    simulate("moving", {"--strategy", "pmp", "--steps", "4", "--motion", "2"});
    simulate("gamma", {"--strategy", "pmp", "--steps", "8", "--scene", "board"});
    simulate("white", {"--world", "ideal", "--scene", "board", "--primaries"});
    for (const std::string height : {"0", "20", "40"}) {
      simulate("plane_" + height, {"--strategy", "pmp", "--steps", "4", "--scene", "board",
                                   "--shift", "0", "0", height});
    }

    run({"reconstruct", "%/scan", "--anyway", "--phase", "%/wrapped.tiff", "-o", "%/cloud.ply"});
    run({"calibrate", "height", "%/plane_0", "%/plane_20", "%/plane_40", "--heights", "0,20,40",
         "--anyway", "-o", "%/heights.npy"});
  }

 protected:
  void expect_written(const fs::path& file) const {
    const ProgramRun run = write_to(target());
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_TRUE(fs::is_regular_file(file));
    EXPECT_NE(contents(file), "old");
    EXPECT_NE(contents(file), "");

    for (const auto& entry : fs::directory_iterator(folder())) {
      EXPECT_NE(entry.path().extension(), ".part") << entry.path();
    }
  }

 private:
  static void run(const Words& words) {
    const ProgramRun run = run_program(with_inputs(words));
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  static void simulate(const std::string& name, const Words& flags) {
    Words words{"simulate", "%/" + name, "--camera", "64x48"};
    words.insert(words.end(), flags.begin(), flags.end());
    run(words);
  }
};

class OutputProgramFileFlags : public WritesResults {};

TEST_P(OutputProgramFileFlags, WriteANewFile) {
  expect_written(target());
}

TEST_P(OutputProgramFileFlags, ReplaceAFileAndKeepItsPermissions) {
  std::ofstream(target()) << "old";
  fs::permissions(target(), fs::perms(0640));
  expect_written(target());
  EXPECT_EQ(fs::status(target()).permissions(), fs::perms(0640));
}

TEST_P(OutputProgramFileFlags, ReplaceTheTargetOfALink) {
  const fs::path below = folder() / "below";
  fs::create_directory(below);
  std::ofstream(below / "real") << "old";
  fs::create_symlink("below/real", target());

  expect_written(below / "real");
  EXPECT_EQ(fs::read_symlink(target()), "below/real");
  EXPECT_EQ(entries_in(below), 1);
}

TEST_P(OutputProgramFileFlags, MakeNoFileCalledDash) {
  expect_no_file_called_dash();
}

INSTANTIATE_TEST_SUITE_P(Of, OutputProgramFileFlags, testing::ValuesIn(file_flags));

/// Refused before any work, so that these need no inputs.
class OutputProgramDeviceOutputs : public WritesOutput {};

TEST_P(OutputProgramDeviceOutputs, AreRefused) {
  const fs::path pipe = folder() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);

  for (const fs::path& special : {fs::path("/dev/null"), pipe, folder()}) {
    fs::create_symlink(special, target());
    expect_failed(write_to(target()), 1, "not a regular file");
    EXPECT_EQ(fs::read_symlink(target()), special);
    fs::remove(target());
  }

  fs::rename(pipe, target());
  expect_failed(write_to(target()), 1, "not a regular file");
  EXPECT_TRUE(fs::is_fifo(target()));
  EXPECT_EQ(entries_in(folder()), 1);
}

TEST_P(OutputProgramDeviceOutputs, AreNoFolders) {
  fs::create_directory(target());
  expect_failed(write_to(target()), 1, "not a regular file");
  EXPECT_EQ(entries_in(target()), 0);
  EXPECT_EQ(entries_in(folder()), 1);
}

TEST_P(OutputProgramDeviceOutputs, AreInNoMissingFolder) {
  expect_failed(write_to(folder() / "missing" / GetParam().name), 1, "No such file or directory");
  EXPECT_EQ(entries_in(folder()), 0);
}

TEST_P(OutputProgramDeviceOutputs, AreInNoFolderThatIsNotWritable) {
  const fs::path locked = folder() / "locked";
  fs::create_directory(locked);
  fs::permissions(locked, fs::perms(0555));
  expect_failed(write_to(locked / GetParam().name), 1, "Permission denied");
  EXPECT_EQ(entries_in(folder()), 1);
}

INSTANTIATE_TEST_SUITE_P(Of, OutputProgramDeviceOutputs,
                         testing::ValuesIn(joined(file_flags, idle_flags)));

/// Flags that a rig file can set: not arguments and -o, and its `mesh` is another setting.
std::vector<WritingFlag> rig_flags() {
  std::vector<WritingFlag> flags = joined(file_flags, idle_flags);
  std::erase_if(flags, [](const WritingFlag& one) {
    return !one.flag.starts_with("--") || one.flag == "--mesh";
  });
  return flags;
}

class OutputProgramRigFiles : public WritesOutput {};

TEST_P(OutputProgramRigFiles, NameNoOutputElsewhere) {
  const std::string rig = folder() / "rig.yaml", setting = GetParam().flag.substr(2);
  std::ofstream(rig) << setting << ": '" << GetParam().begin << target().string() << "'\n";
  expect_failed(run_with({"--rig", rig}), 2, "only to the working folder");
  EXPECT_EQ(entries_in(folder()), 1);
}

INSTANTIATE_TEST_SUITE_P(Of, OutputProgramRigFiles, testing::ValuesIn(rig_flags()));

/// As OutputProgramDeviceOutputs, of flags that have no case of OutputProgramFileFlags.
class OutputProgramIdleOutputs : public WritesOutput {};

TEST_P(OutputProgramIdleOutputs, MakeNoFileCalledDash) {
  expect_no_file_called_dash();
}

INSTANTIATE_TEST_SUITE_P(Of, OutputProgramIdleOutputs,
                         testing::ValuesIn(joined(joined(idle_flags, folder_flags),
                                                  slow_folder_flags)));

class OutputProgramFolderFlags : public WritesResults {};

TEST_P(OutputProgramFolderFlags, MakeANewFolder) {
  const ProgramRun run = write_to(target());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_GT(entries_in(target()), 0);
}

TEST_P(OutputProgramFolderFlags, RefuseAFileADeviceAndAPipe) {
  const auto expect_refused = [&] {
    const ProgramRun run = write_to(target());
    EXPECT_NE(run.exit_code, 0);
    expect_failed(run, target());
  };

  std::ofstream(target()) << "precious";
  expect_refused();
  EXPECT_EQ(contents(target()), "precious");

  const fs::path pipe = folder() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const fs::path& special : {fs::path("/dev/null"), pipe}) {
    fs::remove(target());
    fs::create_symlink(special, target());
    expect_refused();
    EXPECT_EQ(fs::read_symlink(target()), special);
  }
}

INSTANTIATE_TEST_SUITE_P(Of, OutputProgramFolderFlags, testing::ValuesIn(folder_flags));

TEST(OutputProgram, OutputFlagsAreAllTestedHere) {
  std::set<std::string> tested;
  for (const auto& flags : {file_flags, idle_flags, folder_flags, slow_folder_flags}) {
    for (const WritingFlag& flag : flags) tested.insert(flag.flag);
  }

  const std::regex added(R"(add_output\(\s*"([^",]+))");
  int found = 0;
  for (const auto& entry : fs::directory_iterator(SLIPSTREAM_SOURCE_FOLDER "/app")) {
    const std::string source = contents(entry.path());
    for (std::sregex_iterator at(source.begin(), source.end(), added), end; at != end; ++at) {
      EXPECT_TRUE(tested.contains((*at)[1])) << (*at)[1] << " in " << entry.path();
      ++found;
    }
  }
  EXPECT_GT(found, 30);
}

/// Flags of simulate that do not go together.
TEST(OutputProgram, SimulatedOutputsAreRefusedBeforeAFolderIsMade) {
  const TemporaryFolder folder;
  for (const auto& [name, flags, part] : std::vector<std::tuple<std::string, Words, std::string>>{
           {"scan", {"--paint", "0.3"}, "--paint needs --colour or --primaries"},
           {"scan", {"--primaries", "--unquantised"}, "--unquantised"},
           {"x.slip", {"--primaries"}, "need a folder"},
           {"x.slip", {"--second-camera"}, "need a folder"},
           {"x.slip", {"--boards", "2"}, "need a folder"},
           {"x.slip", {"--turntable", "3"}, "need a folder"}}) {
    Words words{"simulate", folder.path() / name, "--camera", "64x48"};
    words.insert(words.end(), flags.begin(), flags.end());
    const ProgramRun run = run_program(words);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
    EXPECT_EQ(entries_in(folder.path()), 0);
  }
}

TEST(OutputProgram, FoldersOfScansAreMadeWithTheirParents) {
  const TemporaryFolder folder;
  const std::string recording = folder.path() / "scan.slip";
  ASSERT_EQ(run_program({"simulate", recording, "--camera", "64x48"}).exit_code, 0);

  for (const char* const name : {"new/run", "newer/"}) {
    const ProgramRun run = run_program({"convert", recording, "-o", folder.path() / name});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_GT(entries_in(folder.path() / name), 0);
  }
}

TEST(OutputProgram, ManifestOfOutputsListsFilesOnly) {
  const TemporaryFolder folder;
  copy_simulated_scan({"--camera", "64x48"}, folder.path() / "scan");
  const std::string manifest = folder.path() / "done.jsonl";
  const ProgramRun run =
      run_program({"reconstruct", folder.path() / "scan", "-o", "-", "--manifest", manifest});
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_NE(run.err.find("--manifest lists files"), std::string::npos) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_FALSE(fs::exists(manifest));
}

}  // namespace slipstream::output_program_test
