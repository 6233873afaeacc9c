// Pictures without compression: BMP, PGM and NumPy's.
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/io/detail/pictures.h"
#include "slipstream/io/file.h"

namespace slipstream {
namespace {

using namespace std::string_view_literals;
using Bytes = std::span<const std::uint8_t>;

std::string_view text_in(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

constexpr std::size_t bmp_header = 54;

/// Lines of a BMP file fill whole words of four bytes.
std::size_t bmp_line(std::uint64_t columns, std::uint64_t bits) {
  return (columns * bits + 31) / 32 * 4;
}

/// Four bytes for each level: blue, green, red and one that says nothing.
bool is_grey(Bytes palette) {
  bool grey = palette.size() == 4 * std::size_t{256};
  for (std::size_t i = 0; i < palette.size(); ++i) grey &= i % 4 == 3 || palette[i] == i / 4;
  return grey;
}

/// Takes the next number off a PGM file's text, past blanks and comments.
std::optional<std::uint32_t> next_number(std::string_view& text) {
  while (!text.empty() && !std::isdigit(static_cast<unsigned char>(text[0]))) {
    text.remove_prefix(text[0] == '#' ? std::min(text.find('\n'), text.size()) : 1);
  }
  const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
  const auto number = number_in<std::uint32_t>(text.substr(0, digits));
  text.remove_prefix(digits);
  return number;
}

/// The numbers in the text of a PGM file, or in its binary part.
template <class Sample>
Picture pgm_picture(std::string_view text, Size size, int channels, bool binary,
                    std::uint32_t most) {
  Image<Sample> samples({size.width * channels, size.height}, uninitialised);
  for (Sample& sample : samples) {
    if (binary) {
      sample = number_at<Sample, std::endian::big>(
          {reinterpret_cast<const std::uint8_t*>(text.data()), sizeof(Sample)}, 0);
      text.remove_prefix(sizeof(Sample));
      continue;
    }
    const auto number = next_number(text);
    if (!number || *number > most) throw Error("not a whole PGM file: truncated");
    sample = static_cast<Sample>(*number);
  }
  return {std::move(samples), channels};
}

constexpr auto npy_magic = "\x93NUMPY\x01\x00"sv;  // and the version, 1.0
constexpr std::size_t npy_preamble = npy_magic.size() + 2;

/// What stands between the two, which are taken off the text's front with it; empty where they do
/// not stand there.
std::string_view take_between(std::string_view& text, std::string_view before,
                              std::string_view after) {
  const std::size_t end = text.find(after, before.size());
  if (!text.starts_with(before) || end == std::string_view::npos) return {};
  const std::string_view between = text.substr(before.size(), end - before.size());
  text.remove_prefix(end + after.size());
  return between;
}

/// The numbers behind the header of a NumPy file, which are as many as it says.
template <class Number>
Picture npy_picture(std::string_view numbers, Size size) {
  Image<Number> image(size, uninitialised);
  const std::size_t wanted = image.pixel_count() * sizeof(Number);
  if (numbers.size() != wanted) {
    throw Error(fmt::format("has {} bytes of numbers; its shape says {}", numbers.size(), wanted));
  }
  std::memcpy(image.begin(), numbers.data(), wanted);
  return {std::move(image)};
}

}  // namespace

std::uint64_t bmp_pixels(Bytes bytes) {
  const HeaderNumbers number{bytes, true};
  if (number(14, 4) == 12) return number(18, 2) * number(20, 2);
  const auto height = static_cast<std::int32_t>(number(22, 4));  // negative: top row first
  return number(18, 4) * static_cast<std::uint64_t>(std::abs(std::int64_t{height}));
}

Picture read_bmp(Bytes bytes) {
  const auto refuse = [](const char* why) {
    throw Error(fmt::format("not a whole BMP file{}", why));
  };
  if (bytes.size() < bmp_header) refuse("");
  const auto number = [&](std::size_t at) { return number_at<std::uint32_t>(bytes, at); };
  const std::size_t pixels = number(10), header = number(14);
  const auto height = static_cast<std::int32_t>(number(22));
  const std::uint32_t columns = number(18), bits = number_at<std::uint16_t>(bytes, 28);
  const std::uint32_t compression = number(30);
  if (header < 40) refuse(": a header of another kind");
  constexpr std::uint32_t by_masks = 3;  // of 32 bits, as a rule those of blue, green and red
  if ((bits != 8 && bits != 24 && bits != 32) || (compression != 0 && compression != by_masks)) {
    refuse(": only pixels of 8, 24 or 32 bits without compression are read");
  }
  const auto rows = static_cast<std::uint64_t>(std::abs(std::int64_t{height}));
  const std::size_t line = bmp_line(columns, bits);
  if (columns < 1 || rows < 1 || pixels > bytes.size() || (bytes.size() - pixels) / line < rows) {
    refuse(": truncated");
  }
  const std::size_t palette = 14 + header;
  const bool has_palette = bits == 8 && palette <= pixels;
  const Bytes colours = has_palette ? bytes.subspan(palette, pixels - palette) : Bytes{};
  const int channels = bits == 8 && (!has_palette || is_grey(colours)) ? 1 : 3;
  const Size size{static_cast<int>(columns), static_cast<int>(rows)};
  Image<std::uint8_t> samples({size.width * channels, size.height}, uninitialised);
  for (int row = 0; row < size.height; ++row) {
    const auto stored = static_cast<std::size_t>(height < 0 ? row : size.height - 1 - row);
    const std::uint8_t* from = bytes.data() + pixels + stored * line;
    std::uint8_t* to = samples.row(row);
    for (int column = 0; column < size.width; ++column, from += bits / 8, to += channels) {
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
  return {std::move(samples), channels};
}

std::vector<std::uint8_t> bmp_file_of(const PictureView& picture) {
  const auto* const samples = std::get_if<ImageView<const std::uint8_t>>(&picture.samples);
  if (samples == nullptr || picture.channels > 3) return {};
  const auto channels = static_cast<std::uint32_t>(picture.channels);
  const std::uint32_t palette = channels == 1 ? 256 : 0, bits = 8 * channels;
  const std::uint32_t first = bmp_header + 4 * palette;
  const auto [width, height] = picture.size();
  const std::size_t line = bmp_line(static_cast<std::uint64_t>(width), bits);
  const auto size = static_cast<std::uint32_t>(line * static_cast<std::size_t>(height));
  std::vector<std::uint8_t> bytes{'B', 'M'};
  append_numbers(bytes, first + size, 0U, first, 40U, width, height, std::uint16_t{1},
                 static_cast<std::uint16_t>(bits), 0U, size, 0U, 0U, palette, 0U);
  for (std::uint32_t level = 0; level < palette; ++level) append_numbers(bytes, level * 0x010101U);
  for (int row = height - 1; row >= 0; --row) {
    const std::size_t end = bytes.size() + line;
    const std::uint8_t* pixel = samples->row(row);
    for (int column = 0; column < width; ++column, pixel += channels) {
      std::reverse_copy(pixel, pixel + channels, std::back_inserter(bytes));
    }
    bytes.resize(end);
  }
  return bytes;
}

std::uint64_t pgm_pixels(Bytes bytes) {
  std::string_view text = text_in(bytes).substr(2);
  const std::uint64_t columns = next_number(text).value_or(0);
  return columns * next_number(text).value_or(0);
}

Picture read_pgm(Bytes bytes) {
  std::string_view text = text_in(bytes);
  const char kind = text[1];
  text.remove_prefix(2);
  const auto columns = next_number(text), rows = next_number(text), levels = next_number(text);
  const bool binary = kind == '5' || kind == '6', coloured = kind == '3' || kind == '6';
  if (kind == '1' || kind == '4') {
    throw Error("a picture of one bit a pixel; grey levels are wanted");
  }
  constexpr std::uint32_t longest = 1U << 30;
  if (!columns || !rows || !levels || *columns < 1 || *rows < 1 || *columns > longest ||
      *rows > longest || *levels < 1 || *levels > 65535 || text.empty()) {
    throw Error("not a whole PGM file");
  }
  text.remove_prefix(1);
  const std::size_t wide = *levels > 255 ? 2 : 1, channels = coloured ? 3 : 1;
  const std::size_t numbers = std::size_t{*columns} * *rows * channels;
  // In letters a number takes two at least, but for the last.
  if (text.size() < (binary ? numbers * wide : 2 * numbers - 1)) {
    throw Error("not a whole PGM file: truncated");
  }
  const auto read = wide == 2 ? pgm_picture<std::uint16_t> : pgm_picture<std::uint8_t>;
  return read(text, {static_cast<int>(*columns), static_cast<int>(*rows)},
              static_cast<int>(channels), binary, *levels);
}

std::vector<std::uint8_t> pgm_file_of(const PictureView& picture) {
  return std::visit(
      [&]<class Sample>(const ImageView<const Sample>& samples) -> std::vector<std::uint8_t> {
        if (std::is_floating_point_v<Sample> || picture.channels != 1) return {};
        const std::string header = fmt::format("P5\n{} {}\n{}\n", samples.width(), samples.height(),
                                               sizeof(Sample) == 1 ? 255 : 65535);
        std::vector<std::uint8_t> bytes(header.begin(), header.end());
        for (int row = 0; row < samples.height(); ++row) {
          const Sample* const line = samples.row(row);
          for (int column = 0; column < samples.width(); ++column) {
            append_numbers<std::endian::big>(bytes, line[column]);
          }
        }
        return bytes;
      },
      picture.samples);
}

Picture read_npy(Bytes bytes) {
  constexpr std::size_t longest_header = 1024;
  const std::string_view text = text_in(bytes);
  if (text.size() < npy_preamble || !text.starts_with(npy_magic)) {
    throw Error("not a NumPy file of version 1.0");
  }
  const auto length = number_at<std::uint16_t>(bytes, npy_magic.size());
  if (length > longest_header || text.size() < npy_preamble + length) {
    throw Error("not a whole NumPy file");
  }
  std::string_view header = text.substr(npy_preamble, length);
  const std::string_view size = take_between(header, "{'descr': '<f", "'");
  const auto rows =
      number_in<int>(take_between(header, ", 'fortran_order': False, 'shape': (", ", "));
  const auto columns = number_in<int>(take_between(header, "", "), }"));
  const bool ends = header.find_first_not_of(' ') == header.size() - 1 && header.ends_with('\n');
  if ((size != "4" && size != "8") || !rows || !columns || !ends) {
    throw Error(
        "not rows x columns of little-endian float32 or float64; numpy.ascontiguousarray(map, "
        "dtype='<f4') is");
  }
  const std::int64_t pixels =
      *rows < 0 || *columns < 0 ? 0 : static_cast<std::int64_t>(*rows) * *columns;
  if (pixels == 0 || pixels > static_cast<std::int64_t>(largest_picture)) {
    throw Error(
        fmt::format("says that it has {} pixels; 1 to {} are read", pixels, largest_picture));
  }
  const auto read = size == "4" ? npy_picture<float> : npy_picture<double>;
  return read(text.substr(npy_preamble + length), {*columns, *rows});
}

std::vector<std::uint8_t> npy_file_of(const PictureView& picture) {
  return std::visit(
      [&]<class Number>(const ImageView<const Number>& numbers) {
        std::string header =
            fmt::format("{{'descr': '<f{}', 'fortran_order': False, 'shape': ({}, {}), }}",
                        sizeof(Number), numbers.height(), numbers.width());
        constexpr std::size_t block =
            64;  // what is before the numbers fills so many bytes, or twice
        header.append(block - 1 - (npy_preamble + header.size()) % block, ' ').push_back('\n');
        std::string file(npy_magic);
        append_numbers(file, static_cast<std::uint16_t>(header.size()));
        file += header;
        std::vector<std::uint8_t> bytes(file.begin(), file.end());
        for (int row = 0; row < numbers.height(); ++row) {
          const auto* const line = reinterpret_cast<const std::uint8_t*>(numbers.row(row));
          bytes.insert(bytes.end(), line,
                       line + static_cast<std::size_t>(numbers.width()) * sizeof(Number));
        }
        return bytes;
      },
      picture.samples);
}

}  // namespace slipstream
