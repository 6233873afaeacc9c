// What the program tells of itself.
#include <algorithm>
#include <regex>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/app/program.h"

namespace slipstream::help_test {

TEST(Help, SaysWhichItIs) {
  const ProgramRun run = run_program({"--version"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run_program({"version"}).out, run.out);
  EXPECT_EQ(run_program({"-V"}).out, run.out);
  EXPECT_TRUE(std::regex_match(run.out, std::regex("[0-9.]+(\\+g[0-9a-f]{7,}(-dirty)?)?\\s*")))
      << run.out;
}

TEST(Help, HasHelpWithExamples) {
  for (const char* command : {"simulate", "reconstruct"}) {
    const ProgramRun run = run_program({command, "--help-all"});
    EXPECT_EQ(run.exit_code, 0);
    EXPECT_LT(run.out.find("Example"), run.out.find("Common options:"));
    EXPECT_LT(run.out.find("Common options:"), run.out.find("Other options:"));
    EXPECT_NE(run.out.find("--json"), std::string::npos);
    EXPECT_NE(run.out.find("--threads"), std::string::npos);
    EXPECT_EQ(run_program({"help", command}).out, run_program({command, "--help"}).out);
  }
  EXPECT_NE(run_program({"help", "patterns"}).out.find("--period-pixels"), std::string::npos);
}

TEST(Help, HelpIsShort) {
  for (const char* command :
       {"reconstruct", "check", "measure", "simulate", "capture", "live", "view"}) {
    const ProgramRun run = run_program({command, "--help"});
    std::istringstream lines(run.out);
    std::ptrdiff_t count = 0;
    for (std::string line; std::getline(lines, line); ++count) {
      EXPECT_LE(line.size(), 100u) << command << ": " << line;
    }
    EXPECT_LE(count, 40) << command;
    EXPECT_NE(run.out.find("--help-all"), std::string::npos) << command;
  }
}

TEST(Help, ShowsAFlagOnlyByItsPresentName) {
  const std::string all = run_program({"reconstruct", "--help-all"}).out;
  EXPECT_NE(all.find("--widest-gap"), std::string::npos);
  EXPECT_EQ(all.find("--fill"), std::string::npos) << all;
}

TEST(Help, FillsTheLinesOfADescription) {
  const std::string margin(26, ' ');
  std::istringstream lines(run_program({"simulate", "--help-all"}).out);
  std::string before;
  for (std::string line; std::getline(lines, line); before = line) {
    // Both belong to a description.
    if (!line.starts_with(margin) || !before.starts_with(margin)) continue;
    const std::size_t first_word = line.find(' ', margin.size()) - margin.size();
    EXPECT_GT(before.size() + 1 + std::min(first_word, line.size() - margin.size()), 100u) << line;
  }
}

TEST(Help, ListsItsCommandsInGroups) {
  const ProgramRun run = run_program({"--help"});
  EXPECT_EQ(run.exit_code, 0);
  std::size_t at = 0;
  for (const char* text : {"Usage: slipstream COMMAND", "Scan:", "  reconstruct",
                           "Calibrate:", "Live:", "Files:", "Measure:", "Learn:", "  simulate"}) {
    at = run.out.find(text, at);
    ASSERT_NE(at, std::string::npos) << text;
  }
  EXPECT_EQ(run_program({"help"}).out, run.out);
}

TEST(Help, GreetsWithCommandsToBeginWith) {
  const ProgramRun run = run_program({});
  EXPECT_EQ(run.exit_code, 0);
  for (const char* text : {"slipstream demo", "slipstream reconstruct", "slipstream --help"}) {
    EXPECT_NE(run.out.find(text), std::string::npos) << text;
  }
  EXPECT_LT(std::ranges::count(run.out, '\n'), 15);
}

}  // namespace slipstream::help_test
