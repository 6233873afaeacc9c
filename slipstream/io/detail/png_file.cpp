#include <algorithm>
#include <array>
#include <bit>
#include <csetjmp>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <libdeflate.h>
#include <png.h>

#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/io/detail/pictures.h"
#include "slipstream/io/file.h"

namespace slipstream {
namespace {

/// What libpng reads from, and why it could not.
struct Source {
  std::span<const std::uint8_t> left;
  std::array<char, 80> fault{};
};

void take(png_structp png, png_bytep to, std::size_t count) {
  auto& left = static_cast<Source*>(png_get_io_ptr(png))->left;
  if (count > left.size()) png_error(png, "truncated");
  std::copy_n(left.begin(), count, to);
  left = left.subspan(count);
}

[[noreturn]] void refuse(png_structp png, png_const_charp why) {
  auto& fault = static_cast<Source*>(png_get_error_ptr(png))->fault;
  std::string_view(why).copy(fault.data(), fault.size() - 1);
  png_longjmp(png, 1);
}

void ignore(png_structp, png_const_charp) {}

/// libpng's own memory for one file.
struct Reader {
  explicit Reader(Source& source)
      : png(png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, refuse, ignore)),
        info(png_create_info_struct(png)) {
    png_set_read_fn(png, &source, take);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }

  png_structp png;
  png_infop info;
};

/// False where libpng refuses: it jumps back to here, past nothing that has a destructor.
bool read_into(Picture& picture, png_structp png, png_infop info) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
  png_read_info(png, info);
  const std::uint64_t width = png_get_image_width(png, info);
  const std::uint64_t height = png_get_image_height(png, info);
  if (width * height > largest_picture) {  // its header need not be where png_pixels looks for it
    png_error(png, "it has too many pixels");
  }
  png_set_palette_to_rgb(png);
  png_set_expand_gray_1_2_4_to_8(png);
  png_set_strip_alpha(png);
  if (std::endian::native == std::endian::little) png_set_swap(png);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  picture.channels = png_get_channels(png, info);
  const Size size{static_cast<int>(width) * picture.channels, static_cast<int>(height)};
  const auto read_rows = [&](auto& samples) {
    for (int row = 0; row < passes * size.height; ++row) {
      png_read_row(png, reinterpret_cast<png_bytep>(samples.row(row % size.height)), nullptr);
    }
  };
  if (png_get_bit_depth(png, info) == 16) {
    read_rows(picture.samples.emplace<Image<std::uint16_t>>(size, uninitialised));
  } else {
    read_rows(picture.samples.emplace<Image<std::uint8_t>>(size, uninitialised));
  }
  png_read_end(png, nullptr);
  return true;
}

std::uint32_t big_endian(std::span<const std::uint8_t> bytes, std::size_t at) {
  return number_at<std::uint32_t, std::endian::big>(bytes, at);
}

constexpr std::uint32_t chunk_named(const char (&name)[5]) {
  std::uint32_t number = 0;
  for (int i = 0; i < 4; ++i) number = number << 8 | static_cast<std::uint8_t>(name[i]);
  return number;
}

struct Chunk {
  std::uint32_t name = 0;
  std::span<const std::uint8_t> data;
};

/// Takes a chunk from what is left; false where it is not whole.
bool take_chunk(std::span<const std::uint8_t>& left, Chunk& chunk) {
  constexpr std::size_t around = 12;  // length, name, check sum
  if (left.size() < around) return false;
  const std::size_t length = big_endian(left, 0);
  if (length > left.size() - around) return false;
  const auto checked = left.subspan(4, 4 + length);
  const std::uint32_t sum = big_endian(left, 8 + length);
  if (libdeflate_crc32(0, checked.data(), checked.size()) != sum) return false;
  chunk = {big_endian(checked, 0), checked.subspan(4)};
  left = left.subspan(around + length);
  return true;
}

int paeth(int left, int above, int corner) {
  const int to_left = std::abs(above - corner), to_above = std::abs(left - corner);
  const int to_corner = std::abs(left + above - 2 * corner);
  if (to_left <= to_above && to_left <= to_corner) return left;
  return to_above <= to_corner ? above : corner;
}

/// Undoes the filter of a row of pixels of `step` bytes, PNG 1.2, Section 6; false for an unknown
/// one.
template <std::size_t step>
bool unfilter(const std::uint8_t* filtered, const std::uint8_t* above,
              std::span<std::uint8_t> row) {
  const auto add = [&](const auto& predicted) {
    std::array<std::uint8_t, step> left{}, corner{};  // read back from the row they would wait
    for (std::size_t i = 0; i < row.size(); ++i) {
      std::uint8_t &before = left[i % step], &above_before = corner[i % step];
      before =
          static_cast<std::uint8_t>(filtered[1 + i] + predicted(before, above[i], above_before));
      above_before = above[i];
      row[i] = before;
    }
  };
  switch (filtered[0]) {
    case 0:
      add([](int, int, int) { return 0; });
      return true;
    case 1:
      add([](int left, int, int) { return left; });
      return true;
    case 2:
      add([](int, int up, int) { return up; });
      return true;
    case 3:
      add([](int left, int up, int) { return (left + up) / 2; });
      return true;
    case 4:
      add(paeth);
      return true;
    default:
      return false;
  }
}

/// The rows of a picture, each with its filter before it, to its pixels; none where one is unknown.
template <class Pixel>
std::optional<Picture> unfiltered(const std::uint8_t* rows, Size size) {
  Image<Pixel> image(size, uninitialised);
  const std::size_t bytes = static_cast<std::size_t>(size.width) * sizeof(Pixel);
  const std::vector<std::uint8_t> zeros(bytes);
  const std::uint8_t* above = zeros.data();
  for (int row = 0; row < size.height; ++row, rows += bytes + 1) {
    auto* const line = reinterpret_cast<std::uint8_t*>(image.row(row));
    if (!unfilter<sizeof(Pixel)>(rows, above, {line, bytes})) return std::nullopt;
    above = line;
  }
  if constexpr (sizeof(Pixel) == 2 && std::endian::native == std::endian::little) {
    for (Pixel& pixel : image) pixel = static_cast<Pixel>(pixel << 8 | pixel >> 8);
  }
  return Picture{std::move(image)};
}

/// None where they are not so many.
std::unique_ptr<std::uint8_t[]> inflated(const std::vector<std::uint8_t>& packed,
                                         std::size_t size) {
  auto bytes = std::make_unique_for_overwrite<std::uint8_t[]>(size);
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>
      decompressor(libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (decompressor == nullptr) throw std::bad_alloc();
  if (libdeflate_zlib_decompress(decompressor.get(), packed.data(), packed.size(), bytes.get(),
                                 size, nullptr) != LIBDEFLATE_SUCCESS) {
    return nullptr;
  }
  return bytes;
}

void put_chunk(std::vector<std::uint8_t>& bytes, std::uint32_t name,
               std::span<const std::uint8_t> data) {
  append_numbers<std::endian::big>(bytes, static_cast<std::uint32_t>(data.size()));
  const std::size_t checked = bytes.size();
  append_numbers<std::endian::big>(bytes, name);
  bytes.insert(bytes.end(), data.begin(), data.end());
  append_numbers<std::endian::big>(bytes,
                                   libdeflate_crc32(0, &bytes[checked], bytes.size() - checked));
}

std::vector<std::uint8_t> deflated(const std::vector<std::uint8_t>& bytes) {
  constexpr int level = 4;  // half as large as none, at a fifth of the time of the smallest
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(level), libdeflate_free_compressor);
  if (compressor == nullptr) throw std::bad_alloc();
  std::vector<std::uint8_t> packed(libdeflate_zlib_compress_bound(compressor.get(), bytes.size()));
  packed.resize(libdeflate_zlib_compress(compressor.get(), bytes.data(), bytes.size(),
                                         packed.data(), packed.size()));
  return packed;
}

/// `rows`: each with its filter before it.
std::vector<std::uint8_t> png_file_of(Size size, int bits, bool in_colour,
                                      const std::vector<std::uint8_t>& rows) {
  std::vector<std::uint8_t> header;
  append_numbers<std::endian::big>(header, size.width, size.height);
  header.push_back(static_cast<std::uint8_t>(bits));
  header.push_back(in_colour ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY);
  header.insert(header.end(),
                {PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE, PNG_INTERLACE_NONE});
  constexpr std::array<std::uint8_t, 8> signature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  std::vector<std::uint8_t> bytes(signature.begin(), signature.end());
  put_chunk(bytes, chunk_named("IHDR"), header);
  put_chunk(bytes, chunk_named("IDAT"), deflated(rows));
  put_chunk(bytes, chunk_named("IEND"), {});
  return bytes;
}

/// Each with the filter Sub before it.
template <class Sample>
std::vector<std::uint8_t> filtered_rows(const ImageView<const Sample>& samples, int channels) {
  std::vector<std::uint8_t> rows;
  rows.reserve((static_cast<std::size_t>(samples.width()) * sizeof(Sample) + 1) *
               static_cast<std::size_t>(samples.height()));
  for (int row = 0; row < samples.height(); ++row) {
    const Sample* const line = samples.row(row);
    rows.push_back(PNG_FILTER_VALUE_SUB);
    for (int i = 0; i < samples.width(); ++i) {
      const int left = i < channels ? 0 : line[i - channels];
      if (sizeof(Sample) == 2) {
        rows.push_back(static_cast<std::uint8_t>((line[i] >> 8) - (left >> 8)));
      }
      rows.push_back(static_cast<std::uint8_t>(line[i] - left));
    }
  }
  return rows;
}

/// What most frames are, grey, 8 or 16 bits, line by line, in half of libpng's time. None for other
/// pictures and those that are not whole: libpng says why.
std::optional<Picture> read_plain_grey(std::span<const std::uint8_t> bytes) {
  std::span<const std::uint8_t> left = bytes.subspan(8);
  Chunk chunk;
  if (!take_chunk(left, chunk) || chunk.name != chunk_named("IHDR") || chunk.data.size() != 13) {
    return {};
  }
  const std::uint8_t* const header = chunk.data.data();
  const std::uint32_t width = big_endian(chunk.data, 0), height = big_endian(chunk.data, 4);
  constexpr std::uint32_t longest = 1'000'000;  // libpng's
  const bool is_grey = std::all_of(header + 9, header + 13, [](int zero) { return zero == 0; });
  if (!is_grey || (header[8] != 8 && header[8] != 16) || width - 1 >= longest ||
      height - 1 >= longest || std::uint64_t{width} * height > largest_picture) {
    return {};
  }
  std::vector<std::uint8_t> packed;
  packed.reserve(bytes.size());
  while (chunk.name != chunk_named("IEND")) {
    if (!take_chunk(left, chunk)) return {};
    const bool is_critical = (chunk.name & 0x20000000) == 0;
    const bool of_pixels = chunk.name == chunk_named("IDAT");
    if (is_critical && !of_pixels && chunk.name != chunk_named("IEND")) return {};
    if (of_pixels) packed.insert(packed.end(), chunk.data.begin(), chunk.data.end());
  }
  const std::size_t row = 1 + std::size_t{width} * header[8] / 8;
  const std::unique_ptr<std::uint8_t[]> rows = inflated(packed, row * height);
  if (rows == nullptr) return {};
  const Size size{static_cast<int>(width), static_cast<int>(height)};
  if (header[8] == 8) return unfiltered<std::uint8_t>(rows.get(), size);
  return unfiltered<std::uint16_t>(rows.get(), size);
}

}  // namespace

std::uint64_t png_pixels(std::span<const std::uint8_t> bytes) {
  const HeaderNumbers number{bytes, false};
  return number(16, 4) * number(20, 4);
}

Picture read_png(std::span<const std::uint8_t> bytes) {
  if (auto plain = read_plain_grey(bytes)) return *std::move(plain);
  Source source{.left = bytes};
  const Reader reader(source);
  if (reader.info == nullptr) throw std::bad_alloc();
  Picture picture;
  if (!read_into(picture, reader.png, reader.info)) {
    throw Error(std::string("not a whole PNG file: ") + source.fault.data());
  }
  return picture;
}

std::vector<std::uint8_t> png_file_of(const PictureView& picture) {
  return std::visit(
      [&]<class Sample>(const ImageView<const Sample>& samples) -> std::vector<std::uint8_t> {
        if constexpr (std::is_integral_v<Sample>) {
          return png_file_of(picture.size(), 8 * sizeof(Sample), picture.channels == 3,
                             filtered_rows(samples, picture.channels));
        }
        return {};
      },
      picture.samples);
}

std::vector<std::uint8_t> one_bit_png_file_of(const Image<std::uint8_t>& picture) {
  std::vector<std::uint8_t> rows;
  for (int row = 0; row < picture.height(); ++row) {
    rows.push_back(PNG_FILTER_VALUE_NONE);
    for (int column = 0; column < picture.width(); ++column) {
      if (column % 8 == 0) rows.push_back(0);
      if (picture(column, row) != 0) {
        rows.back() = static_cast<std::uint8_t>(rows.back() | 0x80 >> column % 8);
      }
    }
  }
  return png_file_of(picture.size(), 1, false, rows);
}

}  // namespace slipstream
