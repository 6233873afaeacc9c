#include "io/file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <span>
#include <string>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "slipstream/error.h"
#include "tests/io/expect_error.h"
#include "tests/io/small_disk.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::file_test {
namespace {

/// Expects `action` to throw WorldError with a message that contains `part`.
template <class Action>
void expect_not_written(const Action& action, const std::string& part) {
  try {
    action();
    ADD_FAILURE() << "written; expected: " << part;
  } catch (const WorldError& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

}  // namespace

TEST(File, WriteFileReplacesWholeAndLeavesNothingBehind) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "note.txt";
  write_file(path, "first, and longer");
  write_file(path, "second");
  const auto bytes = read_file(path);
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), "second");
  EXPECT_EQ(entries_in(folder.path()), 1);
}

/// Which of three files existed before.
class FileKeptTogether : public testing::TestWithParam<std::vector<const char*>> {};

TEST_P(FileKeptTogether, AllOrNone) {
  const TemporaryFolder folder;
  const auto path = [&](const char* name) { return folder.path() / name; };
  const auto text = [&](const char* name) {
    return std::filesystem::exists(path(name)) ? read_text(path(name)) : "";
  };
  for (const char* name : GetParam()) write_file(path(name), "old");
  const std::string before[]{text("a"), text("b"), text("c")};
  const auto write = [&](bool fails) {
    OutputFile a(path("a")), b(path("b")), c(path("c"));
    for (OutputFile* file : {&a, &b, &c}) file->write({bytes_of("new")});
    if (fails) {
      for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
        if (entry.path().filename().string().starts_with("c.")) std::filesystem::remove(entry);
      }
    }
    OutputFile::keep_together({&a, &b, &c});
  };
  EXPECT_THROW(write(true), WorldError);
  EXPECT_EQ(text("a"), before[0]);
  EXPECT_EQ(text("b"), before[1]);
  EXPECT_EQ(text("c"), before[2]);
  EXPECT_EQ(entries_in(folder.path()), static_cast<int>(GetParam().size()));
  write(false);
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(text(name), "new");
  EXPECT_EQ(entries_in(folder.path()), 3);
}

INSTANTIATE_TEST_SUITE_P(Before, FileKeptTogether,
                         testing::Values(std::vector<const char*>{}, std::vector<const char*>{"b"},
                                         std::vector<const char*>{"a", "b", "c"}));

TEST(File, OutputFileOnlyOneWritesOverTime) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a";
  const auto other_name = folder.path() / "link";
  std::filesystem::create_symlink(path, other_name);
  for (int before = 0; before < 3; ++before) {  // a new file first, then over the one before
    OutputFile first(path, OutputFile::Writing::over_time);
    first.write({bytes_of("first")});
    for (const auto& again : {path, other_name, folder.path() / "." / "a"}) {
      EXPECT_THROW(OutputFile(again, OutputFile::Writing::over_time), WorldError);
    }
    first.keep();
    EXPECT_EQ(read_text(path), "first");
    EXPECT_EQ(entries_in(folder.path()), 2);
  }
}

TEST(File, WriteFileFailsWithoutATrace) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_file(folder.path() / "missing" / "note.txt", "text"), WorldError);
  make_folder(folder.path() / "taken");
  EXPECT_THROW(write_file(folder.path() / "taken", "text"), WorldError);
  EXPECT_EQ(entries_in(folder.path()), 1);
  write_file(folder.path() / "file", "text");
  EXPECT_THROW(make_folder(folder.path() / "file"), WorldError);
  EXPECT_THROW(make_folder(folder.path() / "file" / "below"), WorldError);
}

TEST(File, ReadFileNamesWhatIsMissing) {
  const TemporaryFolder folder;
  expect_error([&] { read_file(folder.path() / "none.png"); }, {"none.png", "no such file"});
  expect_error([&] { read_file(folder.path()); }, {"folder"});
}

TEST(File, ReadFileRefusesWhatIsNoFileAtOnce) {
  const TemporaryFolder folder;
  const auto pipe = folder.path() / "pipe", loop = folder.path() / "loop";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::filesystem::create_symlink(loop, loop);
  std::filesystem::create_symlink("/dev/zero", folder.path() / "zero");
  expect_error([&] { read_file(pipe); }, {"pipe", "expected a file"});
  expect_error([&] { read_file(folder.path() / "zero"); }, {"zero", "expected a file"});
  expect_error([&] { read_file("/dev/null"); }, {"/dev/null", "expected a file"});
  expect_error([&] { read_file(loop); }, {"loop", "symbolic links"});
  expect_error([&] { read_file(std::string(5000, 'a')); }, {"aaa", "too long"});
}

TEST(File, ReadFileRefusesWhatIsTooLargeBeforeItIsRead) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "large";
  write_file(path, "");
  std::filesystem::resize_file(path, std::uintmax_t{1} << 40);
  expect_error([&] { read_file(path); }, {"large", "1099511627776 bytes", "limit"});
  expect_error([&] { read_text(path); }, {"large", "limit 1048576"});
}

TEST(File, WriteFileReplacesTheTargetOfALink) {
  const TemporaryFolder folder;
  const auto below = folder.path() / "below", link = folder.path() / "link",
             other = below / "other";
  make_folder(below);
  std::filesystem::create_symlink("below/other", link);

  // First the target is missing, then it exists.
  for (const char* text : {"first", "second"}) {
    write_file(link, text);
    EXPECT_EQ(read_text(other), text);
    EXPECT_TRUE(std::filesystem::is_symlink(link));
    EXPECT_EQ(entries_in(below), 1);
  }
}

TEST(File, WriteFileRefusesLinksToDevicesPipesFoldersAndInARing) {
  const TemporaryFolder folder;
  const auto pipe = folder.path() / "pipe", link = folder.path() / "link";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  expect_not_written([&] { write_file(pipe, "text"); }, "pipe: not a regular file");

  const auto loop = folder.path() / "loop";
  std::filesystem::create_symlink(loop, loop);
  expect_not_written([&] { write_file(loop, "text"); }, "symbolic links");

  for (const auto& target : {pipe, std::filesystem::path("/dev/null"), folder.path()}) {
    std::filesystem::create_symlink(target, link);
    for (const auto writing : {FileWriting::at_once, FileWriting::over_time}) {
      expect_not_written([&] { const OutputFile file(link, writing); }, "link: not a regular file");
    }
    EXPECT_EQ(std::filesystem::read_symlink(link), target);
    std::filesystem::remove(link);
  }
}

TEST(File, WriteFileRefusesAnOpenFileWithoutAName) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "gone", link = folder.path() / "link";
  const Descriptor descriptor(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  std::filesystem::remove(path);
  std::filesystem::create_symlink(fmt::format("/proc/self/fd/{}", int{descriptor}), link);

  expect_not_written([&] { write_file(link, "text"); }, "link: not a regular file");
  EXPECT_EQ(entries_in(folder.path()), 1);
}

TEST(File, OutputFileKeepsThePermissionsOfTheFileItReplaces) {
  using std::filesystem::perms;
  const TemporaryFolder folder;
  const auto path = folder.path() / "note";
  for (const auto writing : {FileWriting::at_once, FileWriting::over_time}) {
    for (const perms before : {perms(0640), perms(0600), perms(0444), perms(0666)}) {
      write_file(path, "first");
      std::filesystem::permissions(path, before);
      OutputFile again(path, writing);
      again.keep();
      EXPECT_EQ(std::filesystem::status(path).permissions(), before);
    }
  }
}

TEST(File, WriteFileNamesAsLongAsTheyMayBe) {
  const TemporaryFolder folder;
  const auto path = folder.path() / std::string(255, 'n');
  write_file(path, "text");
  EXPECT_EQ(read_text(path), "text");
}

TEST(File, OutputFileTemporaryNamesAreNoTwiceTheSame) {
  const TemporaryFolder folder;
  const OutputFile first(folder.path() / "note"), second(folder.path() / "note");
  EXPECT_EQ(entries_in(folder.path()), 2);
  const std::regex name("note\\.[0-9a-f]{16}\\.part");
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    EXPECT_TRUE(std::regex_match(entry.path().filename().string(), name)) << entry.path();
  }
}

TEST(File, OutputFileHandlersRemoveWhatIsBeingWritten) {
  const TemporaryFolder folder;
  write_file(folder.path() / "note", "first");
  OutputFile kept(folder.path() / "note");
  kept.keep();
  // In a separate process: remove_temporary_files() makes destructors block until the end.
  EXPECT_EXIT(
      {
        OutputFile file(folder.path() / "other");
        remove_temporary_files();
        std::_Exit(entries_in(folder.path()));
      },
      testing::ExitedWithCode(1), "");
}

TEST(File, OutputFileOverTimeHasItsOwnNameWhereThatIsFree) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "note";
  const auto put = [](OutputFile& file, std::string_view text) {
    file.write({std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size())});
  };
  {
    OutputFile file(path, OutputFile::Writing::over_time);
    put(file, "first");
    file.sync();
    EXPECT_EQ(read_text(path), "first");
  }
  EXPECT_EQ(read_text(path), "first");
  OutputFile again(path, OutputFile::Writing::over_time);
  put(again, "second");
  EXPECT_EQ(read_text(path), "first");
  again.keep();
  EXPECT_EQ(read_text(path), "second");
  EXPECT_EQ(entries_in(folder.path()), 1);
}

TEST(File, OutputFileWhatGrowsByMuchIsWholeThoughItLeavesTheMemory) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "large";
  std::vector<std::uint8_t> all(OutputFile::most_unsynced + (10 << 20) + 7);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(i * i >> 12);
  OutputFile file(path, OutputFile::Writing::over_time);
  for (std::span<const std::uint8_t> rest(all); !rest.empty();) {
    const auto part = rest.first(std::min<std::size_t>(rest.size(), 700'001));
    file.write({part});
    rest = rest.subspan(part.size());
  }
  EXPECT_TRUE(read_file(path) == all);
}

TEST(File, OutputFileFullDiskLeavesWhatWasThere) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "note";
  write_file(path, "first");
  {
    const SmallDisk disk(100);
    EXPECT_THROW(write_file(path, std::string(1000, 'x')), WorldError);
  }
  EXPECT_EQ(read_text(path), "first");
  EXPECT_EQ(entries_in(folder.path()), 1);
}

TEST(File, ReadFileFailureToOpenAnyFileIsTheSystems) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "note";
  write_file(path, "first");

  const FewDescriptors none(0);
  EXPECT_THROW(read_file(path), WorldError);
  EXPECT_THROW(write_file(path, "second"), WorldError);
}

TEST(File, OutputFileWithoutItsLockLeavesWhatWasThere) {
  const TemporaryFolder folder;
  write_file(folder.path() / "before", "first");

  // A new file takes the only free number; an existing one has none to be opened for its lock.
  int lowest = -1;
  {
    const Descriptor free(::open("/dev/null", O_RDONLY | O_CLOEXEC));
    lowest = free;
  }
  {
    const FewDescriptors one(static_cast<rlim_t>(lowest + 1));
    EXPECT_THROW(OutputFile(folder.path() / "new", FileWriting::over_time), WorldError);
  }
  {
    const FewDescriptors none(static_cast<rlim_t>(lowest));
    EXPECT_THROW(OutputFile(folder.path() / "before", FileWriting::over_time), WorldError);
  }

  EXPECT_EQ(read_text(folder.path() / "before"), "first");
  EXPECT_EQ(entries_in(folder.path()), 1);
}

}  // namespace slipstream::file_test
