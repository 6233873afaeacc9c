// Uncompressed picture formats: BMP, PGM and NumPy; and JPEG, by libjpeg-turbo.
#include "io/plain_pictures.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <turbojpeg.h>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/npz_file.h"
#include "io/pictures.h"

namespace slipstream {
namespace {

using Bytes = std::span<const std::uint8_t>;

std::string_view text_in(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

constexpr std::size_t bmp_header = 54;

/// Lines of a BMP file are padded to four bytes.
std::size_t bmp_line(std::uint64_t columns, std::uint64_t bits) {
  return (columns * bits + 31) / 32 * 4;
}

/// Four bytes for each level: blue, green, red and an unused one.
bool is_grey(Bytes palette) {
  bool grey = palette.size() == 4 * std::size_t{256};
  for (std::size_t i = 0; i < palette.size(); ++i) grey &= i % 4 == 3 || palette[i] == i / 4;
  return grey;
}

/// Removes and returns the next number of a PGM file's text, skipping blanks and comments.
std::optional<std::uint32_t> next_number(std::string_view& text) {
  while (!text.empty() && !std::isdigit(static_cast<unsigned char>(text[0]))) {
    text.remove_prefix(text[0] == '#' ? std::min(text.find('\n'), text.size()) : 1);
  }

  const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
  const auto number = number_in<std::uint32_t>(text.substr(0, digits));
  text.remove_prefix(digits);
  return number;
}

using Decoder = std::unique_ptr<void, int (*)(tjhandle)>;

/// 0 x 0 if the header is damaged.
Size size_in(Bytes bytes, const Decoder& decoder) {
  Size size;
  int sampling = 0, colours = 0;

  const int failed = tjDecompressHeader3(decoder.get(), bytes.data(), bytes.size(), &size.width,
                                         &size.height, &sampling, &colours);
  return failed == 0 ? size : Size{};
}

/// Number of scans of a JPEG file, small copies in it included. Its samples contain no such mark.
int scans_in(Bytes bytes) {
  constexpr std::string_view mark = "\xff\xda";
  const std::string_view text = text_in(bytes);

  int scans = 0;
  for (std::size_t at = text.find(mark); at != text.npos; at = text.find(mark, at + 1)) ++scans;
  return scans;
}

}  // namespace

Picture read_bmp(Bytes bytes, std::size_t frames) {
  const auto require = [](bool good, const char* why) {
    throw_if(!good, "not a complete BMP file{}", why);
  };
  require(bytes.size() >= bmp_header, "");

  // 1. The header: places of the pixels, size and bits.
  const auto number = [&](std::size_t at) { return number_at<std::uint32_t>(bytes, at); };
  const std::size_t pixels = number(10), header = number(14);
  const auto height = static_cast<std::int32_t>(number(22));  // negative: top row first
  const std::uint32_t columns = number(18), bits = number_at<std::uint16_t>(bytes, 28);
  const auto rows = static_cast<std::uint64_t>(std::abs(std::int64_t{height}));

  require_readable(columns * rows, frames);
  require(header >= 40, ": unsupported header");

  constexpr std::uint32_t none = 0, by_masks = 3;  // of 32 bits, as a rule of blue, green and red
  require((bits == 8 || bits == 24 || bits == 32) && (number(30) == none || number(30) == by_masks),
          ": expected uncompressed pixels of 8, 24 or 32 bits");

  const std::size_t line = bmp_line(columns, bits);
  require(
      columns >= 1 && rows >= 1 && pixels <= bytes.size() && (bytes.size() - pixels) / line >= rows,
      ": truncated");

  // 2. The palette, which follows the header.
  const std::size_t palette = 14 + header;
  const bool has_palette = bits == 8 && palette <= pixels;
  const Bytes colours = has_palette ? bytes.subspan(palette, pixels - palette) : Bytes{};
  const int channels = bits == 8 && (!has_palette || is_grey(colours)) ? 1 : 3;

  // 3. The pixels, stored from the bottom row to the top unless the height is negative.
  const Size size{static_cast<int>(columns), static_cast<int>(rows)};
  Picture picture({size, channels});

  for (int row = 0; row < size.height; ++row) {
    const auto stored = static_cast<std::size_t>(height < 0 ? row : size.height - 1 - row);
    const std::uint8_t* from = bytes.data() + pixels + stored * line;
    std::uint8_t* to = picture.row(row);

    for (int column = 0; column < size.width; ++column, from += bits / 8, to += channels) {
      // Colours are stored as blue, green, red; levels beyond the palette are black.
      const std::size_t colour = 4 * std::size_t{*from};
      if (channels == 1) {
        *to = *from;
      } else if (bits != 8) {
        std::reverse_copy(from, from + 3, to);
      } else if (colour + 3 < colours.size()) {
        std::reverse_copy(&colours[colour], &colours[colour] + 3, to);
      } else {
        std::fill_n(to, 3, std::uint8_t{0});
      }
    }
  }

  return picture;
}

std::vector<std::uint8_t> bmp_file_of(const PictureView& picture) {
  if (picture.kind.bits != 8) return {};

  const auto channels = static_cast<std::uint32_t>(picture.kind.channels);
  const std::uint32_t palette = channels == 1 ? 256 : 0, bits = 8 * channels;
  const std::uint32_t first = bmp_header + 4 * palette;

  const auto [width, height] = picture.kind.size;
  const std::size_t line = bmp_line(static_cast<std::uint64_t>(width), bits);
  const auto size = static_cast<std::uint32_t>(line * static_cast<std::size_t>(height));

  // The file header of 14 bytes, the picture header of 40, and a grey palette.
  std::vector<std::uint8_t> bytes{'B', 'M'};
  append_numbers(bytes, first + size, 0U, first, 40U, width, height, std::uint16_t{1},
                 static_cast<std::uint16_t>(bits), 0U, size, 0U, 0U, palette, 0U);
  for (std::uint32_t level = 0; level < palette; ++level) append_numbers(bytes, level * 0x010101U);

  bytes.resize(first + size);

  for (int row = 0; row < height; ++row) {
    std::uint8_t* to = &bytes[first + static_cast<std::size_t>(height - 1 - row) * line];
    const std::uint8_t* pixel = picture.row(row);
    for (int column = 0; column < width; ++column, pixel += channels) {
      to = std::reverse_copy(pixel, pixel + channels, to);
    }
  }

  return bytes;
}

Picture read_pgm(Bytes bytes, std::size_t frames) {
  // 1. The header: the kind, three numbers and one blank.
  std::string_view text = text_in(bytes);
  const char kind = text.size() > 1 ? text[1] : '\0';
  throw_if(kind == '1' || kind == '4', "a picture of one bit per pixel; expected grey levels");
  text.remove_prefix(std::min<std::size_t>(2, text.size()));

  const std::uint64_t columns = next_number(text).value_or(0), rows = next_number(text).value_or(0);
  const std::uint32_t levels = next_number(text).value_or(0);
  require_readable(columns * rows, frames);

  const bool binary = kind == '5' || kind == '6', coloured = kind == '3' || kind == '6';
  throw_if(columns * rows < 1 || levels < 1 || levels > 65535 || text.empty(),
           "not a complete PGM file");
  text.remove_prefix(1);

  // 2. The size of the picture, checked against the file's before memory is allocated.
  const int bytes_each = levels > 255 ? 2 : 1;
  const PictureKind form{
      {static_cast<int>(columns), static_cast<int>(rows)}, coloured ? 3 : 1, 8 * bytes_each};
  const std::size_t numbers = columns * rows * (coloured ? 3 : 1);

  // In ASCII, each number takes at least two characters, except the last.
  throw_if(text.size() < (binary ? rows * form.row_bytes() : 2 * numbers - 1),
           "not a complete PGM file: truncated");

  // 3. The levels, in ASCII or binary.
  Picture picture(form);
  picture.used_bits = std::max(8, static_cast<int>(std::bit_width(levels)));

  std::uint8_t* to = picture.row(0);
  for (std::size_t n = 0; n < numbers; ++n, to += bytes_each) {
    if (binary) {  // most significant first
      std::reverse_copy(text.begin(), text.begin() + bytes_each, to);
      text.remove_prefix(static_cast<std::size_t>(bytes_each));
      const std::uint32_t level = bytes_each == 2 ? number_at<std::uint16_t>({to, 2}, 0) : *to;
      throw_if(level > levels, "has a level above its highest, {}", levels);
      continue;
    }

    const auto number = next_number(text);
    if (!number || *number > levels) throw Error("not a complete PGM file: truncated");
    for (int i = 0; i < bytes_each; ++i) to[i] = static_cast<std::uint8_t>(*number >> (8 * i));
  }

  return picture;
}

std::vector<std::uint8_t> pgm_file_of(const PictureView& picture) {
  const auto& [size, channels, bits] = picture.kind;
  if (picture.kind.real() || channels != 1) return {};

  const std::string header =
      fmt::format("P5\n{} {}\n{}\n", size.width, size.height, bits == 8 ? 255 : 65535);
  std::vector<std::uint8_t> bytes(header.begin(), header.end());

  for (int row = 0; row < size.height; ++row) {
    const std::uint8_t* const line = picture.row(row);
    for (std::size_t i = 0; i < picture.kind.row_bytes(); ++i) {
      bytes.push_back(line[bits == 8 ? i : i ^ 1]);  // most significant first
    }
  }

  return bytes;
}

Picture read_npy(Bytes bytes) {
  // 1. The header.
  const auto header = npy_header(bytes);
  throw_if(!header, "not a NumPy file of version 1.0");
  const bool is_float = header->type == "<f4", is_double = header->type == "<f8";
  throw_if((!is_float && !is_double) || header->by_columns || header->shape.size() != 2,
           "not rows x columns of little-endian float32 or float64; convert it with "
           "numpy.ascontiguousarray(map, dtype='<f4')");

  // 2. The size.
  const int rows = header->shape.front(), columns = header->shape.back();
  const std::int64_t pixels = std::int64_t{rows} * columns;
  throw_if(pixels == 0 || pixels > static_cast<std::int64_t>(largest_picture),
           "declares {} pixels; expected 1 to {}", pixels, largest_picture);

  const PictureKind kind{{columns, rows}, 1, is_float ? 32 : 64};
  const std::size_t wanted = kind.row_bytes() * static_cast<std::size_t>(rows);

  throw_if(header->numbers.size() != wanted, "has {} bytes of numbers; its shape requires {}",
           header->numbers.size(), wanted);

  // 3. The numbers.
  Picture picture(kind);
  std::memcpy(picture.row(0), header->numbers.data(), wanted);

  return picture;
}

std::vector<std::uint8_t> npy_file_of(const PictureView& picture) {
  std::string header =
      fmt::format("{{'descr': '<f{}', 'fortran_order': False, 'shape': ({}, {}), }}",
                  picture.kind.bits / 8, picture.kind.size.height, picture.kind.size.width);

  constexpr std::size_t block = 64;  // the preamble is padded to a multiple of this
  header.append(block - 1 - (npy_preamble + header.size()) % block, ' ').push_back('\n');

  std::vector<std::uint8_t> bytes(npy_magic.begin(), npy_magic.end());
  append_numbers(bytes, static_cast<std::uint16_t>(header.size()));
  bytes.insert(bytes.end(), header.begin(), header.end());

  for (int row = 0; row < picture.kind.size.height; ++row) {
    bytes.insert(bytes.end(), picture.row(row), picture.row(row) + picture.kind.row_bytes());
  }

  return bytes;
}

bool decode_jpeg(Bytes bytes, Image<std::uint8_t>& grey) {
  const Decoder decoder(tjInitDecompress(), tjDestroy);
  const auto [width, height] = grey.size();
  return size_in(bytes, decoder) == grey.size() &&
         tjDecompress2(decoder.get(), bytes.data(), bytes.size(), grey.begin(), width, 0, height,
                       TJPF_GRAY, TJFLAG_LIMITSCANS) == 0;
}

void recompress_jpeg(Image<std::uint8_t>& samples, int channels, int quality) {
  const Size size{samples.width() / channels, samples.height()};
  const int format = channels == 1 ? TJPF_GRAY : TJPF_RGB;
  const int sampling = channels == 1 ? TJSAMP_GRAY : TJSAMP_420;

  const Decoder encoder(tjInitCompress(), tjDestroy), decoder(tjInitDecompress(), tjDestroy);
  std::uint8_t* jpeg = nullptr;
  unsigned long length = 0;

  const bool encoded = tjCompress2(encoder.get(), samples.begin(), size.width, 0, size.height,
                                   format, &jpeg, &length, sampling, quality, 0) == 0;
  const bool decoded = encoded && tjDecompress2(decoder.get(), jpeg, length, samples.begin(),
                                                size.width, 0, size.height, format, 0) == 0;

  tjFree(jpeg);
  throw_if(!decoded, "a picture of {} does not fit into a JPEG file", text_of(size));
}

Picture read_jpeg(Bytes bytes, std::size_t frames) {
  const Size size = size_in(bytes, Decoder(tjInitDecompress(), tjDestroy));
  require_readable(static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height),
                   frames);

  // A scan of a progressive JPEG passes over the whole picture, and may take a few bytes.
  constexpr int most_scans = 100;
  const int scans = scans_in(bytes);
  throw_if(scans > most_scans, "has {} scans; limit {}", scans, most_scans);

  Picture picture({size});
  picture.lossy = true;
  throw_if(size == Size{} || !decode_jpeg(bytes, std::get<Image<std::uint8_t>>(picture.samples)),
           "not a complete JPEG file of 8 bits");
  return picture;
}

}  // namespace slipstream
