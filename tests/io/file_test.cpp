#include "slipstream/io/file.h"

#include <gtest/gtest.h>

#include "slipstream/error/error.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream {
namespace {

TEST(WriteFile, ReplacesWholeAndLeavesNothingBehind) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "note.txt";
  write_file(path, "first, and longer");
  write_file(path, "second");
  const auto bytes = read_file(path);
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), "second");
  EXPECT_EQ(entries_in(folder.path()), 1);
}

TEST(WriteFile, FailsWithoutATrace) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_file(folder.path() / "missing" / "note.txt", "text"), WorldError);
  make_folder(folder.path() / "taken");
  EXPECT_THROW(write_file(folder.path() / "taken", "text"), WorldError);
  EXPECT_EQ(entries_in(folder.path()), 1);
  write_file(folder.path() / "file", "text");
  EXPECT_THROW(make_folder(folder.path() / "file"), WorldError);
  EXPECT_THROW(make_folder(folder.path() / "file" / "below"), WorldError);
}

TEST(ReadFile, NamesWhatIsMissing) {
  const TemporaryFolder folder;
  expect_error([&] { read_file(folder.path() / "none.png"); }, {"none.png", "no such file"});
  expect_error([&] { read_file(folder.path()); }, {"folder"});
}

}  // namespace
}  // namespace slipstream
