// The program that starts the one with all commands, when it is copied elsewhere.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <sys/wait.h>

#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::whole_program_test {
namespace fs = std::filesystem;

class WholeProgramCopied : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(path("bin"));
    fs::copy_file(SLIPSTREAM_PROGRAM, path("bin/slipstream"));
  }

  [[nodiscard]] fs::path path(const char* name) const { return folder_.path() / name; }

  /// Exit code and stderr of the copy.
  [[nodiscard]] std::pair<int, std::string> run(const std::string& words) const {
    const std::string command = path("bin/slipstream").string() + " " + words + " >" +
                                path("out").string() + " 2>" + path("err").string();
    const int status = std::system(command.c_str());  // NOLINT(cert-env33-c)
    return {WEXITSTATUS(status), contents(path("err"))};
  }

  void expect_refused() const {
    for (const char* words : {"live --help", "--help", "reconstruct scan --rig rig.yaml"}) {
      const auto [exit_code, err] = run(words);
      EXPECT_EQ(exit_code, 1) << words << err;
      EXPECT_NE(err.find("second program"), std::string::npos) << err;
      EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
    }
  }

  TemporaryFolder folder_;
};

TEST_F(WholeProgramCopied, SaysWhatIsMissing) {
  expect_refused();
  EXPECT_EQ(run("--version").first, 0);
  EXPECT_EQ(run("reconstruct nothing").first, 2);
}

TEST_F(WholeProgramCopied, RunsNoOtherProgramOfThatName) {
  for (const char* place : {"bin/whole", "libexec/slipstream"}) {
    fs::create_directories(path(place));
    std::ofstream(path(place) / "slipstream")
        << "#!/bin/sh\ntouch " << path("run").string() << '\n';
    fs::permissions(path(place) / "slipstream", fs::perms(0755));
    expect_refused();

    // A program, but not of slipstream.
    fs::copy_file("/bin/true", path(place) / "slipstream", fs::copy_options::overwrite_existing);
    expect_refused();
  }
  EXPECT_FALSE(fs::exists(path("run")));
}

TEST_F(WholeProgramCopied, RunsTheOtherOneThatIsCopiedWithIt) {
  const fs::path whole = fs::path(SLIPSTREAM_PROGRAM).parent_path() / "whole" / "slipstream";
  for (const char* place : {"libexec/slipstream", "bin/whole"}) {
    fs::create_directories(path(place));
    fs::copy_file(whole, path(place) / "slipstream");
    const auto [exit_code, err] = run("live --help");
    EXPECT_EQ(exit_code, 0) << err;
    fs::remove(path(place) / "slipstream");
  }
}

}  // namespace slipstream::whole_program_test
