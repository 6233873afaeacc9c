// The chain of directories in a TIFF file, classic or BigTIFF, in either byte order. libtiff finds
// a page only by walking from the first, so that a stack would take time in the square of its
// pages.
#include "io/tiff_directories.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "base/throw_if-inl.h"
#include "io/file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// Numbers of a TIFF file have a size in bytes each, twice as large in BigTIFF.
struct TiffLayout {
  bool big_endian = false;
  std::size_t offset_bytes = 4, count_bytes = 2, tag_bytes = 12;
  std::size_t first_directory = 4;  ///< where the header has its offset
  std::size_t value = 8;            ///< where a tag has its value
};

TiffLayout layout_in(const InputFile& file) {
  std::array<std::uint8_t, 4> magic{};
  if (!file.read(0, {magic})) throw Error("incomplete TIFF file: no header");

  // MM is big-endian. The number that follows is 42, or 43 in BigTIFF.
  TiffLayout layout;
  layout.big_endian = magic[0] == 'M';
  const bool is_big_tiff = magic[layout.big_endian ? 3 : 2] == 43;
  if (is_big_tiff) {
    layout.offset_bytes = layout.count_bytes = 8;
    layout.tag_bytes = 20;
    layout.first_directory = 8;
    layout.value = 12;
  }

  return layout;
}

std::uint64_t tiff_number(std::span<const std::uint8_t> bytes, bool big_endian) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const std::size_t place = big_endian ? i : bytes.size() - 1 - i;
    number = number << 8 | bytes[place];
  }
  return number;
}

/// The number at that place of the file; nullopt if the file ends before.
std::optional<std::uint64_t> tiff_number_at(const InputFile& file, std::uint64_t at,
                                            std::size_t size, bool big_endian) {
  std::array<std::uint8_t, 8> bytes{};
  const std::span<std::uint8_t> number(bytes.data(), size);
  if (at > file.size() || !file.read(at, {number})) return std::nullopt;
  return tiff_number(number, big_endian);
}

/// Whether a directory's tags say that it is a reduced copy or a mask of another picture.
bool is_secondary(std::span<const std::uint8_t> tags, const TiffLayout& layout) {
  constexpr std::uint64_t subfile_type = 254, short_integer = 3;
  constexpr std::uint64_t reduced = 1, mask = 4;

  for (; !tags.empty(); tags = tags.subspan(layout.tag_bytes)) {
    if (tiff_number(tags.first(2), layout.big_endian) != subfile_type) continue;

    const std::uint64_t type = tiff_number(tags.subspan(2, 2), layout.big_endian);
    const auto value = tags.subspan(layout.value, type == short_integer ? 2 : 4);
    return (tiff_number(value, layout.big_endian) & (reduced | mask)) != 0;
  }

  return false;
}

/// The tags of the directory at that place; nullopt if it cannot be one.
std::optional<std::vector<std::uint8_t>> tags_at(const InputFile& file, std::uint64_t at,
                                                 const TiffLayout& layout) {
  // Others have below a hundred. libtiff takes time in the square of tags that it does not know.
  constexpr std::uint64_t most_tags = 512;

  const auto count = tiff_number_at(file, at, layout.count_bytes, layout.big_endian);
  if (!count || *count < 1 || *count > most_tags) return std::nullopt;

  std::vector<std::uint8_t> tags(*count * layout.tag_bytes);
  if (!file.read(at + layout.count_bytes, {tags})) return std::nullopt;
  return tags;
}

TiffDirectories read_directories(const InputFile& file) {
  constexpr std::size_t most_pages = 10'000;

  const TiffLayout layout = layout_in(file);
  TiffDirectories found;
  std::uint64_t at =
      tiff_number_at(file, layout.first_directory, layout.offset_bytes, layout.big_endian)
          .value_or(0);

  while (at != 0 || found.offsets.empty()) {
    const int number = static_cast<int>(found.offsets.size());
    found.too_many = found.offsets.size() == most_pages;
    if (found.too_many) {
      found.fault = fmt::format("has more than {} pages", most_pages);
      return found;
    }

    const auto tags = tags_at(file, at, layout);
    if (!tags) {
      found.fault = fmt::format("incomplete TIFF file: directory {} cannot be read", number);
      return found;
    }

    found.offsets.push_back(at);
    if (!is_secondary(*tags, layout)) found.pages.push_back(number);

    // Some programs leave out the offset behind the last directory, which is 0.
    const std::uint64_t end = at + layout.count_bytes + tags->size();
    at = tiff_number_at(file, end, layout.offset_bytes, layout.big_endian).value_or(0);
  }

  return found;
}

/// A file whose directories were read before.
struct KnownTiff {
  fs::path path;
  std::uint64_t size;
  fs::file_time_type written;
  std::shared_ptr<const TiffDirectories> directories;
};

}  // namespace

std::shared_ptr<const TiffDirectories> tiff_directories(const fs::path& path,
                                                        const InputFile& file) {
  constexpr std::size_t most_known = 16;
  static std::mutex mutex;
  static std::deque<KnownTiff> known;

  // 1. The same file as before, if it has not been written since.
  std::error_code unknown_time;
  const fs::file_time_type written = fs::last_write_time(path, unknown_time);
  {
    const std::lock_guard lock(mutex);
    for (const KnownTiff& before : known) {
      const bool same =
          before.path == path && before.size == file.size() && before.written == written;
      if (same && !unknown_time) return before.directories;
    }
  }

  // 2. Any other.
  auto directories = std::make_shared<const TiffDirectories>(read_directories(file));

  // 3. Remembers it. A file that was written a moment ago may be written again at the same time by
  // the clock of the file system.
  constexpr std::chrono::milliseconds tick{100};
  if (!unknown_time && fs::file_time_type::clock::now() - written > tick) {
    const std::lock_guard lock(mutex);
    known.push_back({path, file.size(), written, directories});
    if (known.size() > most_known) known.pop_front();
  }

  return directories;
}

std::uint64_t directory_of_page(const TiffDirectories& directories, std::optional<int> page) {
  const auto& [offsets, pages, fault, too_many] = directories;

  if (!page) {
    if (!fault.empty()) throw Error(fault);
    throw_if(pages.size() > 1, "has {} pages, expected one picture; name a page, as in FILE[0]",
             pages.size());
    return offsets.at(pages.empty() ? 0 : static_cast<std::size_t>(pages.front()));
  }

  const auto number = static_cast<std::size_t>(*page);
  if (number < offsets.size()) return offsets[number];
  throw_if(fault.empty(), "has no page {}", *page);
  throw Error(fault);
}

std::vector<std::uint8_t> header_naming(const InputFile& file, std::uint64_t directory) {
  const TiffLayout layout = layout_in(file);
  std::vector<std::uint8_t> header(layout.first_directory + layout.offset_bytes);
  if (!file.read(0, {header})) throw Error("incomplete TIFF file: no header");

  for (std::size_t i = 0; i < layout.offset_bytes; ++i) {
    const std::size_t place = layout.big_endian ? layout.offset_bytes - 1 - i : i;
    header[layout.first_directory + place] = static_cast<std::uint8_t>(directory >> (8 * i));
  }

  return header;
}

}  // namespace slipstream
