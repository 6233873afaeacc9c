// Runs `slipstream calibrate verify --repeat`.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "slipstream/named_scenes.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::repeat_program_test {

class RepeatProgram : public testing::Test {
 protected:
  void SetUp() override { write_scanner(path("scanner.yaml"), example_scanner({80, 60})); }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  [[nodiscard]] std::vector<std::string> verify(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"calibrate",          "verify",   "--scanner",
                                       path("scanner.yaml"), "--report", path("report")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(RepeatProgram, RehearsesAWarmUpWithTheVirtualScanner) {
  const ProgramRun run = run_program(verify({"--repeat", "0.15", "--source", "virtual", "--json"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;

  const auto document = nlohmann::json::parse(run.out);
  const auto& scans = document["scans"];
  ASSERT_GE(scans.size(), 2U);
  EXPECT_EQ(scans[0]["depth_change_mm"], 0);
  EXPECT_EQ(document["failed_scans"], 0);
  for (const auto& scan : scans) EXPECT_LT(std::abs(scan["depth_change_mm"].get<double>()), 0.2);

  // A virtual scanner does not warm up; each scan has its own noise. A busy machine takes few.
  const bool is_judged = scans.size() >= 9;
  EXPECT_EQ(document["grade"], is_judged ? "good" : "usable") << run.out;
  EXPECT_EQ(document.value("steady_after_minutes", -1.0), is_judged ? 0 : -1) << run.out;
  EXPECT_NE(scans[1]["depth_change_mm"], 0);
  EXPECT_TRUE(scans[1]["temperatures_celsius"].empty());  // it measures none
  EXPECT_NE(contents(path("report/report.html")).find("Depth of a fixed scene over time"),
            std::string::npos);
}

TEST_F(RepeatProgram, EndsOnCtrlCWithWhatItHasMeasured) {
  RunningProgram program(verify({"--repeat", "600", "--source", "virtual"}));
  ASSERT_TRUE(program.wait_for_words("Ctrl-C ends earlier")) << program.words();
  program.send(SIGINT);
  EXPECT_EQ(program.wait(), 0) << program.words();
  EXPECT_NE(program.out().find("too few scans"), std::string::npos) << program.words();
  EXPECT_TRUE(std::filesystem::exists(path("report/report.html")));
}

TEST_F(RepeatProgram, LeavesOutLaterScansThatFail) {
  RunningProgram program(verify({"--repeat", "0.1", "--source", "virtual"}));
  ASSERT_TRUE(program.wait_for_words("Ctrl-C ends earlier")) << program.words();
  std::filesystem::remove(path("scanner.yaml"));
  EXPECT_EQ(program.wait(), 0) << program.words();
  EXPECT_NE(program.err().find("scanner.yaml"), std::string::npos) << program.words();
}

TEST_F(RepeatProgram, TriesTheReportBeforeTheScans) {
  std::filesystem::create_directories(path("report/report.html"));
  const ProgramRun run = run_program(verify({"--repeat", "600", "--source", "virtual"}));
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_NE(run.err.find("report.html"), std::string::npos) << run.err;
}

TEST_F(RepeatProgram, RefusesInOneLine) {
  const auto expect_refused = [&](const std::vector<std::string>& more, const std::string& part) {
    std::vector<std::string> arguments{"calibrate", "verify", "--scanner", path("scanner.yaml")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  };

  expect_refused({"--repeat", "0", "--source", "virtual"}, "--repeat 0");
  expect_refused({"--repeat", "1", "--source", "replay:scan.slip"}, "replay:scan.slip");
  expect_refused({"--repeat", "1"}, "--source");
  expect_refused({"--repeat", "1", "--source", "virtual", "--corners", "13x9"}, "--corners");
  expect_refused({"--repeat", "1", "--source", "virtual", "--settle", "5"}, "--monitor");
  expect_refused({"--source", "virtual"}, "--repeat");
  expect_refused({"poses", "--repeat", "1", "--source", "virtual"}, "--repeat");
  expect_refused({}, "--repeat");
}

}  // namespace slipstream::repeat_program_test
