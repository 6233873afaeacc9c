#include "io/file_names.h"

#include <filesystem>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "io/file.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::file_names_test {
namespace fs = std::filesystem;

/// The names that threads get which call get(wanted) at once.
template <class Get>
std::vector<fs::path> names_of_threads(const Get& get) {
  constexpr std::size_t count = 8;
  std::vector<fs::path> names(count);
  {
    std::vector<std::jthread> threads;
    for (fs::path& name : names) threads.emplace_back([&] { name = get(); });
  }
  return names;
}

TEST(FileNames, NumberedStandsBesideThePath) {
  EXPECT_EQ(numbered("rigs/rig.yaml", 2), "rigs/rig-2.yaml");
  EXPECT_EQ(numbered("boards", 3), "boards-3");
  EXPECT_EQ(numbered("all/boards/", 2), "all/boards-2");
}

TEST(FileNames, NewFileHasANameOfItsOwnInEachThread) {
  const TemporaryFolder folder;
  const fs::path wanted = folder.path() / "scan.slip";

  const std::vector<fs::path> names = names_of_threads([&] {
    const NewFile file(wanted);
    write_file(file.path(), "its contents");
    return file.path();
  });

  EXPECT_EQ(std::set(names.begin(), names.end()).size(), names.size());
  EXPECT_TRUE(fs::exists(wanted));
  EXPECT_TRUE(fs::exists(folder.path() / "scan-8.slip"));
}

TEST(FileNames, NewFileIsRemovedIfItStaysEmpty) {
  const TemporaryFolder folder;
  const fs::path wanted = folder.path() / "cloud.ply";
  { const NewFile file(wanted); }
  EXPECT_TRUE(fs::is_empty(folder.path()));

  EXPECT_THROW(NewFile(folder.path() / "missing" / "cloud.ply"), WorldError);
}

TEST(FileNames, NewFileIsWrittenOverTimeUnderItsOwnName) {
  const TemporaryFolder folder;
  const NewFile file(folder.path() / "scan.slip");
  OutputFile written(file.path(), OutputFile::Writing::over_time);
  written.write({bytes_of("frames")});
  EXPECT_EQ(fs::file_size(file.path()), 6U);
  EXPECT_THROW(OutputFile(file.path(), OutputFile::Writing::over_time), WorldError);

  written.keep();
  EXPECT_EQ(read_text(file.path()), "frames");
}

TEST(FileNames, FreeFolderIsAnotherOneInEachThread) {
  const TemporaryFolder folder;
  const fs::path wanted = folder.path() / "saved" / "scan-20260131";

  const std::vector<fs::path> names = names_of_threads([&] { return make_free_folder(wanted); });
  EXPECT_EQ(std::set(names.begin(), names.end()).size(), names.size());
  for (const fs::path& name : names) EXPECT_TRUE(fs::is_directory(name)) << name;
}

TEST(FileNames, FreeFolderIsRefusedBelowAFile) {
  const TemporaryFolder folder;
  write_file(folder.path() / "file", "text");
  EXPECT_THROW(make_free_folder(folder.path() / "file" / "scan"), WorldError);
}

}  // namespace slipstream::file_names_test
