// Reads files of an earlier version, in written_before/: a scan folder with its scanner file, a
// recording and a rig file; also flags in their old form.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/cloud_file.h"
#include "tests/app/program.h"

namespace slipstream::old_files_test {
namespace fs = std::filesystem;

const fs::path before = fs::path(SLIPSTREAM_SOURCE_FOLDER) / "tests" / "app" / "written_before";

/// Reconstruction gives the cloud that the earlier version wrote.
void expect_as_before(std::vector<std::string> arguments) {
  const TemporaryFolder folder;
  const fs::path cloud = folder.path() / "cloud.ply";
  arguments.insert(arguments.begin(), "reconstruct");
  arguments.insert(arguments.end(), {"--min-component", "20", "-o", cloud.string()});
  const ProgramRun run = run_program(arguments);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Image<float> depths = read_cloud(cloud).cloud.z;
  const Image<float> then = read_cloud(before / "cloud.ply").cloud.z;
  ASSERT_EQ(depths.size(), then.size());
  EXPECT_TRUE(std::equal(depths.begin(), depths.end(), then.begin(),
                         [](float now, float z) { return std::abs(now - z) < 1e-3; }));
}

TEST(OldFiles, AScanFolder) {
  expect_as_before({(before / "scan").string()});
}

TEST(OldFiles, ARecording) {
  expect_as_before({(before / "rec.slip").string()});
}

TEST(OldFiles, ARigFile) {
  expect_as_before({(before / "scan").string(), "--rig", (before / "rig.yaml").string()});
}

TEST(OldFiles, ASwitchWithItsWord) {
  expect_as_before({(before / "scan").string(), "--backwards", "true", "--strategy",
                    "dual-frequency", "--steps", "3", "--high", "16", "--low", "1"});
}

TEST(OldFiles, FlagsByTheirFormerNames) {
  expect_as_before(
      {(before / "scan").string(), "--min-modulation", "15", "--fill", "0", "--smooth", "0"});
}

}  // namespace slipstream::old_files_test
