#include "io/result_files.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "io/file.h"
#include "slipstream/error.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::result_files_test {
namespace fs = std::filesystem;
namespace {

std::string cloud_of(const std::string& pattern, const std::string& scan) {
  return files_of_scan({.cloud = pattern}, {scan, 7}).cloud;
}

}  // namespace

TEST(ResultFiles, TakeTheirNameFromTheScan) {
  const TemporaryFolder folder;
  const fs::path scan = folder.path() / "scan.v1";
  fs::create_directories(scan / "below");

  for (const fs::path& path : {scan, scan / "", scan / ".", scan / "below" / ".."}) {
    EXPECT_EQ(cloud_of("out/{name}.ply", path), "out/scan.v1.ply") << path;
  }
  EXPECT_EQ(cloud_of("{name}-{window}.ply", folder.path() / "scan.slip"), "scan-000007.ply");
  EXPECT_EQ(cloud_of("{name}.ply", folder.path() / "{window}.slip"), "{window}.ply");
}

TEST(ResultFiles, StayInTheirFolderWhateverTheNameOfTheScan) {
  for (const char* scan : {"/", "...slip", "..slip", "list/...slip"}) {
    expect_error([&] { cloud_of("{name}/cloud.ply", scan); }, {scan, "{name}"});
    EXPECT_EQ(cloud_of("cloud-{window}.ply", scan), "cloud-000007.ply");
  }
}

TEST(ResultFiles, FilesReplacedByAreThoseBesideItAndThoseOfPlaceholders) {
  const TemporaryFolder folder;
  const auto path = [&](const char* name) { return folder.path() / name; };
  for (const char* name : {"a.png", "b.png", ".c.png", "a.ply", "m.obj", "m.mtl", "[x].png"}) {
    write_file(path(name), "");
  }

  const auto count = [&](const char* name) { return files_replaced_by(path(name)).size(); };
  EXPECT_EQ(count("a.png"), 1U);
  EXPECT_EQ(count("new.png"), 0U);
  EXPECT_EQ(count("[x].png"), 1U);
  EXPECT_EQ(count("{name}.png"), 4U);
  EXPECT_EQ(count("{name}-{window}.png"), 0U);
  EXPECT_EQ(count("m.obj"), 2U);
}

TEST(ResultFiles, FormatOfEndingIsToldByTheBeginning) {
  const TemporaryFolder folder;
  const auto holds = [&](const char* name, const std::string& text) {
    write_file(folder.path() / name, text);
    return has_format_of_ending(folder.path() / name);
  };
  EXPECT_TRUE(holds("a.ply", "ply\nformat ascii 1.0\n"));
  EXPECT_TRUE(holds("a.PNG", "\x89PNG and more"));
  EXPECT_TRUE(holds("a.slip", ""));
  EXPECT_FALSE(holds("a.slip", "SLIP"));
  EXPECT_FALSE(holds("a.ply", "alias ls=rm"));
  EXPECT_FALSE(holds("bashrc", ""));
  EXPECT_FALSE(holds("a.xyz", "1 2 3"));
}

}  // namespace slipstream::result_files_test
