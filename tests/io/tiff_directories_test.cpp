#include "io/tiff_directories.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "io/file.h"
#include "io/image_file.h"
#include "io/scan_pictures.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::tiff_directories_test {
namespace fs = std::filesystem;

/// Appends the lowest bytes of a number, the lowest first.
void append_low_bytes(std::string& bytes, std::size_t number, int count) {
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(number >> (8 * i) & 0xFF);
}

/// A TIFF file of pages of 2x2 pixels. All pixels of page n have the level n % 251.
std::string stack_of(int pages) {
  std::string file("II*\0", 4);
  append_low_bytes(file, 8, 4);

  for (int n = 0; n < pages; ++n) {
    constexpr std::size_t tags_bytes = 9 * 12;
    const std::size_t pixels = file.size() + 2 + tags_bytes + 4, end = pixels + 4;
    const std::vector<std::pair<int, std::size_t>> tags{{256, 2}, {257, 2}, {258, 8},
                                                        {259, 1}, {262, 1}, {273, pixels},
                                                        {277, 1}, {278, 2}, {279, 4}};

    append_low_bytes(file, tags.size(), 2);
    for (const auto& [tag, value] : tags) {
      append_low_bytes(file, static_cast<std::size_t>(tag), 2);
      append_low_bytes(file, 4, 2);  // 32-bit integers
      append_low_bytes(file, 1, 4);
      append_low_bytes(file, value, 4);
    }

    append_low_bytes(file, n + 1 < pages ? end : 0, 4);
    file.append(4, static_cast<char>(n % 251));
  }

  return file;
}

/// Writes a stack that counts as written some time ago.
fs::path old_stack(const fs::path& folder, int pages) {
  fs::path path = folder / "stack.tif";
  write_file(path, stack_of(pages));
  fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(1));
  return path;
}

TEST(TiffDirectories, AreReadOnceForAllPages) {
  const TemporaryFolder folder;
  const fs::path path = old_stack(folder.path(), 300);
  const auto first = tiff_directories(path, InputFile(path));
  EXPECT_EQ(first->pages.size(), 300U);

  // Each page costs as much as the first, wherever it is.
  for (const int page : {0, 150, 299}) {
    const Image<double> levels = read_levels(fmt::format("{}[{}]", path.string(), page));
    EXPECT_EQ(levels(1, 1), page % 251);
    EXPECT_EQ(tiff_directories(path, InputFile(path)), first);
  }
}

TEST(TiffDirectories, AreReadAgainOfAFileThatWasWritten) {
  const TemporaryFolder folder;
  const fs::path path = old_stack(folder.path(), 3);
  EXPECT_EQ(tiff_directories(path, InputFile(path))->pages.size(), 3U);

  for (const int pages : {5, 4}) {
    write_file(path, stack_of(pages));
    EXPECT_EQ(tiff_directories(path, InputFile(path))->pages.size(), std::size_t(pages));
  }
}

TEST(TiffDirectories, MoreThanTheLimitAreRefusedByName) {
  const TemporaryFolder folder;
  const fs::path path = old_stack(folder.path(), 10'000);
  EXPECT_EQ(images_in_folder(folder.path()).size(), 10'000U);
  EXPECT_EQ(read_levels(path.string() + "[9999]")(0, 0), 9999 % 251);

  old_stack(folder.path(), 10'001);
  expect_error([&] { (void)images_in_folder(folder.path()); },
               {"stack.tif: has more than 10000 pages"});
  expect_error([&] { (void)read_levels(path); }, {"stack.tif: has more than 10000 pages"});
  EXPECT_EQ(read_levels(path.string() + "[1]")(0, 0), 1);
}

TEST(TiffDirectories, OfMoreTagsThanTheLimitAreRefused) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "tags.tif";
  for (const std::size_t tags : {512, 513}) {
    std::string file("II*\0\x08\0\0\0", 8);
    append_low_bytes(file, tags, 2);
    write_file(path, file + std::string(tags * 12 + 4, '\0'));
    EXPECT_EQ(tiff_directories(path, InputFile(path))->fault.empty(), tags == 512);
  }
}

TEST(TiffDirectories, ThatLeadBackAreRefused) {
  const TemporaryFolder folder;
  std::string file = stack_of(1);
  file[8 + 2 + 9 * 12] = 8;  // after its only directory, itself
  write_file(folder.path() / "loop.tif", file);
  expect_error([&] { (void)read_levels(folder.path() / "loop.tif"); }, {"loop.tif: has more than"});
}

}  // namespace slipstream::tiff_directories_test
