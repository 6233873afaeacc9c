#include "io/picture_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <system_error>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/compressed_pictures.h"
#include "io/file.h"
#include "io/plain_pictures.h"
#include "io/tiff_directories.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

using namespace std::string_view_literals;
using Bytes = std::span<const std::uint8_t>;

using ReadPicture = Picture (*)(Bytes bytes, std::size_t frames);

/// Readers by the files' first bytes.
constexpr std::array<std::pair<std::string_view, ReadPicture>, 4> picture_formats{
    {{"\x89PNG\r\n\x1a\n"sv, read_png},
     {"\xff\xd8\xff"sv, read_jpeg},
     {"BM"sv, read_bmp},
     {"P"sv, read_pgm}}};

/// Null if the bytes are not a picture.
ReadPicture reader_of(Bytes bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto* const format = std::ranges::find_if(
      picture_formats, [&](const auto& known) { return text.starts_with(known.first); });
  if (format == picture_formats.end()) return nullptr;

  // The first byte P alone is too little: a digit from 1 to 6 and a blank must follow.
  const bool is_pgm = text.size() > 2 && text[1] >= '1' && text[1] <= '6' &&
                      std::isspace(static_cast<unsigned char>(text[2])) != 0;

  return format->second == read_pgm && !is_pgm ? nullptr : format->second;
}

/// The first bytes of a TIFF file, which is read page by page.
bool is_tiff(const InputFile& file) {
  std::array<char, 4> first{};
  const bool read = file.size() > first.size() &&
                    file.read(0, {{reinterpret_cast<std::uint8_t*>(first.data()), first.size()}});

  // The byte order, II (little-endian) or MM, and then 42 ('*'), or 43 ('+') for BigTIFF.
  const std::string_view magic(first.data(), first.size());
  return read &&
         (magic == "II*\0"sv || magic == "II+\0"sv || magic == "MM\0*"sv || magic == "MM\0+"sv);
}

}  // namespace

PicturePlace place_of(const fs::path& path) {
  const std::string text = path.string();
  const std::size_t bracket = text.rfind('[');
  std::error_code unknown;

  // A file whose name ends in brackets is that file.
  if (!text.ends_with(']') || bracket == text.npos || fs::exists(path, unknown)) return {path};

  const auto page =
      number_in<int>(std::string_view(text).substr(bracket + 1, text.size() - bracket - 2));

  return page && *page >= 0 ? PicturePlace{text.substr(0, bracket), page} : PicturePlace{path};
}

Picture read_picture(const fs::path& path, std::size_t frames) {
  const auto [name, page] = place_of(path);
  const InputFile file(name, largest_picture_file);

  return naming(path.string(), [&, page = page] {
    if (is_tiff(file)) return read_tiff(file, *tiff_directories(name, file), page, frames);
    throw_if(page.has_value(), "{} is not a TIFF file, which alone has pages", name.string());

    const auto memory = std::make_unique_for_overwrite<std::uint8_t[]>(file.size());
    const std::span bytes(memory.get(), file.size());
    if (!file.read(0, {bytes})) throw Error("became shorter while it was read");

    const ReadPicture read = reader_of(bytes);
    if (read == nullptr)
      throw Error("not a picture; expected a complete PNG, TIFF, BMP, PGM or JPEG file");

    return read(bytes, frames);
  });
}

}  // namespace slipstream
