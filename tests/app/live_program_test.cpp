// Runs `slipstream live`: flags, JSON document, signals.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <regex>

#include <gtest/gtest.h>

#include "io/file.h"
#include "slipstream/recording.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"
#include "tests/view/desktop.h"

namespace slipstream::live_program_test {
namespace fs = std::filesystem;

const std::vector<std::string> small{"live",       "--source", "virtual",   "--camera", "64x48",
                                     "--strategy", "pmp",      "--steps",   "4",        "--scene",
                                     "sphere",     "--json",   "--headless"};

std::vector<std::string> with(std::vector<std::string> arguments,
                              const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

/// The number at the first occurrence of a key in a JSON document.
double number_of(const std::string& json, const std::string& key) {
  std::smatch match;
  const std::regex number("\"" + key + "\":\\s*([-+.0-9e]+)");
  return std::regex_search(json, match, number) ? std::stod(match[1]) : std::nan("");
}

TEST(LiveProgram, CountsFramesAndClouds) {
  const ProgramRun run = run_program(with(small, {"--frames", "200"}));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(number_of(run.out, "captured"), 200);
  EXPECT_EQ(number_of(run.out, "lost"), 0);
  EXPECT_EQ(number_of(run.out, "clouds"), 195) << "of six frames each, for motion";
  EXPECT_GT(number_of(run.out, "clouds_per_second"), 0);
  for (const char* key : {"latency_ms", "p50", "p99", "max", "stages", "resynchronisations"}) {
    EXPECT_NE(run.out.find("\"" + std::string(key) + "\""), std::string::npos) << key;
  }
}

TEST(LiveProgram, PacedFramesAllBecomeClouds) {
  const ProgramRun run = run_program(with(small, {"--frames", "60", "--rate", "120"}));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(number_of(run.out, "captured"), 60);
  EXPECT_GE(number_of(run.out, "seconds"), 0.45);
}

TEST(LiveProgram, RecordsReplaysAndWritesTheLastCloud) {
  const TemporaryFolder folder;
  const fs::path recording = folder.path() / "frames.slip", first = folder.path() / "first.ply",
                 second = folder.path() / "second.ply";
  const ProgramRun run = run_program(with(small, {"--frames", "42", "--motion", "0", "--record",
                                                  recording.string(), "-o", first.string()}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const ProgramRun again =
      run_program({"live", "--source", "replay:" + recording.string(), "--rate", "0", "--headless",
                   "--json", "-o", second.string()});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(number_of(again.out, "captured"), 42);
  EXPECT_EQ(number_of(again.out, "clouds"), 39);
  EXPECT_GT(contents(first).size(), 1000U);
  EXPECT_EQ(contents(first), contents(second));
}

TEST(LiveProgram, CountsThePointsOfTheNewestCloud) {
  const TemporaryFolder folder;
  const fs::path cloud = folder.path() / "cloud.ply";
  const ProgramRun run = run_program(with(small, {"--frames", "30", "-o", cloud.string()}));
  ASSERT_EQ(run.exit_code, 0) << run.err;

  const std::string header = contents(cloud).substr(0, 500);
  std::smatch vertices;
  ASSERT_TRUE(std::regex_search(header, vertices, std::regex("element vertex ([0-9]+)")));
  EXPECT_GT(number_of(run.out, "valid"), 500) << run.out;
  EXPECT_EQ(number_of(run.out, "valid"), std::stod(vertices[1])) << "points in the file";
}

TEST(LiveProgram, RecordingsStopAtTheirLimit) {
  const TemporaryFolder folder;
  const auto path = [&](const char* name) { return (folder.path() / name).string(); };
  // Enough frames for a disk that is slower than the camera and leaves some out.
  const ProgramRun live =
      run_program(with(small, {"--frames", "2000", "--record", path("live.slip"), "--publish",
                               "mcap:" + path("live.mcap"), "--limit", "0.1MB"}));
  EXPECT_EQ(live.exit_code, 0) << live.err;
  EXPECT_EQ(number_of(live.out, "captured"), 2000);
  EXPECT_NE(live.err.find("live.slip: limit reached, recording stopped"), std::string::npos)
      << live.err;
  EXPECT_LE(fs::file_size(path("live.slip")), 100'000U);
  EXPECT_TRUE(fs::exists(path("live.mcap")));
  const ProgramRun record =
      run_program({"record", "--source", "replay:" + path("live.slip"), "--rate", "0", "--json",
                   "--limit", "0.03MB", "-o", path("a.slip")});
  EXPECT_EQ(record.exit_code, 0) << record.err;
  EXPECT_NE(record.out.find("\"limit_reached\": true"), std::string::npos) << record.out;
  EXPECT_TRUE(RecordingReader(path("a.slip")).finished());
  EXPECT_EQ(run_program({"record", "--source", "virtual", "--limit", "2", "-o", path("b.slip")})
                .exit_code,
            2);
}

TEST(LiveProgram, DoesNotRecordOntoWhatIsReplayed) {
  const TemporaryFolder folder;
  const std::string recording = (folder.path() / "frames.slip").string();
  ASSERT_EQ(run_program(with(small, {"--frames", "12", "--record", recording})).exit_code, 0);
  const std::string before = contents(recording);
  fs::create_symlink(recording, folder.path() / "link");
  for (const std::string& onto : {recording, (folder.path() / "link").string()}) {
    const ProgramRun live =
        run_program({"live", "--source", "replay:" + recording, "--headless", "--record", onto});
    EXPECT_EQ(live.exit_code, 2);
    EXPECT_NE(live.err.find("is an input"), std::string::npos) << live.err;
    const ProgramRun record =
        run_program({"record", "--source", "replay:" + recording, "-o", onto});
    EXPECT_EQ(record.exit_code, 2);
    EXPECT_NE(record.err.find("is an input"), std::string::npos) << record.err;
  }
  EXPECT_EQ(contents(recording), before);
}

TEST(LiveProgram, AMarkerAndACountTellThePatternToo) {
  for (const char* indexing : {"marker", "counted"}) {
    const ProgramRun run = run_program(with(small, {"--frames", "100", "--indexing", indexing}));
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_GE(number_of(run.out, "clouds"), 75) << indexing;
    EXPECT_EQ(number_of(run.out, "resynchronisations"), 0) << indexing;
  }
}

TEST(LiveProgram, AnInterruptFinishesItsFiles) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const TemporaryFolder folder;
    const fs::path recording = folder.path() / "frames.slip", cloud = folder.path() / "cloud.ply";
    const auto arguments =
        with(small, {"--rate", "200", "--record", recording.string(), "-o", cloud.string()});
    RunningProgram program(arguments);
    EXPECT_TRUE(wait_until([&] {
      std::error_code none;
      const auto bytes = fs::file_size(recording, none);
      return !none && bytes >= 20 * 64 * 48;
    }));
    program.send(signal);
    EXPECT_EQ(program.wait(), 0) << program.err();
    const RecordingReader reader(recording);
    EXPECT_TRUE(reader.finished());
    EXPECT_GE(reader.count(), 10U);
    EXPECT_TRUE(fs::exists(cloud));
  }
}

TEST(LiveProgram, TheEndOfTheDesktopFinishesItsFiles) {
  const Desktop desktop;

  const TemporaryFolder folder;
  const fs::path recording = folder.path() / "frames.slip", cloud = folder.path() / "cloud.ply",
                 messages = folder.path() / "clouds.mcap";
  RunningProgram program({"live", "--source", "virtual", "--world", "ideal", "--camera", "64x48",
                          "--strategy", "pmp", "--steps", "4", "--rate", "60", "--record",
                          recording.string(), "--publish", "mcap:" + messages.string(), "-o",
                          cloud.string()});

  // The window is open, and a few clouds have been made.
  EXPECT_TRUE(wait_until([] {
    return std::system("timeout 5 xdotool search --name 'slipstream live' > /dev/null 2>&1") == 0;
  }));
  EXPECT_TRUE(wait_until([&] {
    std::error_code none;
    const auto bytes = fs::file_size(recording, none);
    return !none && bytes >= 60 * 64 * 48;
  }));

  desktop.crash();
  EXPECT_EQ(program.wait(), 0) << program.err();
  EXPECT_NE(program.err().find("the desktop has ended"), std::string::npos) << program.err();
  EXPECT_TRUE(RecordingReader(recording).finished());
  EXPECT_TRUE(contents(messages).ends_with("MCAP0\r\n"));
  EXPECT_TRUE(fs::exists(cloud));
}

TEST(LiveProgram, ARecordingKnowsTheLightOfTheVirtualScanner) {
  const TemporaryFolder folder;
  const std::string recording = (folder.path() / "frames.slip").string();
  const std::vector<std::string> multiplexed{
      "live",    "--source", "virtual",  "--camera", "96x72",    "--strategy", "pcmp",
      "--steps", "3",        "--frames", "12",       "--record", recording,    "--headless"};
  const ProgramRun recorded = run_program(multiplexed);
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  const ProgramRun replayed =
      run_program({"live", "--source", "replay:" + recording, "--headless", "--json"});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.err;
  EXPECT_EQ(number_of(replayed.out, "clouds"), 10) << replayed.out;
}

TEST(LiveProgram, AFullDiskEndsTheRecordingAndNotTheScan) {
  const TemporaryFolder folder;
  const ProgramRun run = run_program(
      with(small, {"--frames", "300", "--record", (folder.path() / "frames.slip").string()}),
      100'000);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("frames.slip"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("295 clouds"), std::string::npos) << run.err;
}

TEST(LiveProgram, WithoutAScannerTellsWhatThePicturesSay) {
  const TemporaryFolder folder;
  const fs::path scan = folder.path() / "scan";
  ASSERT_EQ(run_program({"simulate", scan.string(), "--camera", "96x72"}).exit_code, 0);
  const std::string described = contents(scan / "scan.yaml");
  write_file(scan / "scan.yaml", std::regex_replace(described, std::regex("scanner:.*\n"), ""));
  const std::vector<std::string> live{"live", "--source", "replay:" + scan.string(), "--headless"};
  const ProgramRun run = run_program(with(live, {"--json"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("pictures without points"), std::string::npos) << run.err;
  const double measured = number_of(run.out, "measured"), dark = number_of(run.out, "too_dark"),
               saturated = number_of(run.out, "saturated");
  EXPECT_EQ(measured + dark + saturated, 96 * 72) << run.out;
  EXPECT_GT(measured, dark);
  EXPECT_GT(number_of(run.out, "median_modulation"), 15);
  const ProgramRun refused =
      run_program(with(live, {"-o", (folder.path() / "cloud.ply").string()}));
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("no points can be made"), std::string::npos) << refused.err;
}

TEST(LiveProgram, FollowsASphereAndMakesAModelOfIt) {
  const TemporaryFolder folder;
  const fs::path model = folder.path() / "model.ply";
  const ProgramRun run =
      run_program({"live",         "--source", "virtual",     "--camera", "160x120", "--strategy",
                   "pmp",          "--steps",  "4",           "--scene",  "sphere",  "--world",
                   "ideal",        "--json",   "--headless",  "--frames", "60",      "--track",
                   "sphere:118.8", "--model",  model.string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_GE(number_of(run.out, "found"), 1) << run.out;
  EXPECT_NE(run.out.find("\"centre_mm\""), std::string::npos);
  EXPECT_GE(number_of(run.out, "views"), 1) << run.out;
  EXPECT_TRUE(fs::exists(model));
}

TEST(LiveProgram, TellsHowManyFramesACloudTakes) {
  // Four steps, and two frames more that measure motion.
  const TemporaryFolder folder;
  const std::string cloud = (folder.path() / "cloud.ply").string();
  for (const char* const flag : {"--output", "--model"}) {
    const ProgramRun run = run_program(with(small, {"--frames", "5", flag, cloud}));
    EXPECT_NE(run.exit_code, 0) << flag;
    EXPECT_NE(run.err.find("a cloud takes 6 frames, and 5 came"), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(cloud)) << flag;
  }
}

TEST(LiveProgram, RefusesWhatCannotBe) {
  const auto expect_refused = [](const std::vector<std::string>& arguments,
                                 const std::string& named) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(named), std::string::npos) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  };
  expect_refused({"live", "--headless", "--source", "magic:1"}, "magic:1");
  expect_refused({"live", "--headless", "--source", "virtual:x"}, "virtual:x");
  expect_refused({"live", "--headless", "--source", "replay:/nowhere"}, "/nowhere");
  expect_refused(with(small, {"--rate", "-1"}), "--rate -1");
  expect_refused(with(small, {"--rate", "nan"}), "--rate: nan");
  expect_refused(with(small, {"--rate", "1e-4"}), "--rate 0.0001");
  expect_refused(with(small, {"--frames", "0"}), "--frames 0");
  expect_refused(with(small, {"--duration", "0"}), "--duration 0");
  expect_refused(with(small, {"--duration", "nan"}), "--duration: nan");
  expect_refused(with(small, {"--indexing", "guess"}), "guess");
  expect_refused(with(small, {"--gamma", "blind"}), "blind");
  expect_refused(with(small, {"-o", "cloud.txt"}), "cloud.txt");
  expect_refused(with(small, {"--model", "model.txt"}), "model.txt");
  expect_refused(with(small, {"--track", "cube"}), "cube");
  expect_refused(with(small, {"--vibrate", "1", "0"}), "--vibrate 1 0");
  expect_refused(with(small, {"--breathe", "1", "9"}), "--breathe 1 9");
  expect_refused(with(small, {"--frequency", "5"}), "more than one period");
}

}  // namespace slipstream::live_program_test
