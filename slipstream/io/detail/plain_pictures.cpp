#include "slipstream/io/detail/plain_pictures.h"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "slipstream/base/error.h"
#include "slipstream/base/number_bytes.h"
#include "slipstream/io/detail/picture_size.h"

namespace slipstream {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t bmp_header = 54;

/// Lines of a BMP file fill whole words of four bytes.
std::size_t bmp_line(std::uint64_t columns, std::uint64_t bits) {
  return (columns * bits + 31) / 32 * 4;
}

/// Blue, green and red of the palette's colours; empty where they are the 256 grey levels.
std::vector<cv::Vec3b> palette_of(Bytes entries) {
  std::vector<cv::Vec3b> colours(256);
  bool grey = entries.size() == 4 * colours.size();
  for (std::size_t i = 0; 4 * i + 3 < entries.size() && i < colours.size(); ++i) {
    colours[i] = {entries[4 * i], entries[4 * i + 1], entries[4 * i + 2]};
    for (int channel = 0; channel < 3; ++channel) grey = grey && colours[i][channel] == i;
  }
  if (grey) colours.clear();
  return colours;
}

}  // namespace

cv::Mat read_bmp(Bytes bytes) {
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
  const auto colours = bits != 8 || palette > pixels
                           ? std::vector<cv::Vec3b>{}
                           : palette_of(bytes.subspan(palette, pixels - palette));
  cv::Mat mat(static_cast<int>(rows), static_cast<int>(columns),
              bits == 8 && colours.empty() ? CV_8UC1 : CV_8UC3);
  for (int row = 0; row < mat.rows; ++row) {
    const auto stored = static_cast<std::size_t>(height < 0 ? row : mat.rows - 1 - row);
    const std::uint8_t* const from = bytes.data() + pixels + stored * line;
    if (mat.channels() == 1) {
      std::copy_n(from, mat.cols, mat.ptr(row));
      continue;
    }
    for (int column = 0; column < mat.cols; ++column) {
      const std::uint8_t* const pixel = from + static_cast<std::size_t>(column) * (bits / 8);
      mat.at<cv::Vec3b>(row, column) =
          bits == 8 ? colours[*pixel] : cv::Vec3b(pixel[0], pixel[1], pixel[2]);
    }
  }
  return mat;
}

std::vector<std::uint8_t> bmp_file_of(const cv::Mat& mat) {
  if (mat.type() != CV_8UC1 && mat.type() != CV_8UC3) return {};
  const std::uint32_t palette = mat.channels() == 1 ? 256 : 0;
  const std::uint32_t first = bmp_header + 4 * palette;
  const auto bits = static_cast<std::uint32_t>(8 * mat.elemSize());
  const std::size_t line = bmp_line(static_cast<std::uint64_t>(mat.cols), bits);
  const auto size = static_cast<std::uint32_t>(line * static_cast<std::size_t>(mat.rows));
  std::vector<std::uint8_t> bytes{'B', 'M'};
  append_numbers(bytes, first + size, 0U, first, 40U, mat.cols, mat.rows, std::uint16_t{1},
                 static_cast<std::uint16_t>(bits), 0U, size, 0U, 0U, palette, 0U);
  for (std::uint32_t level = 0; level < palette; ++level) append_numbers(bytes, level * 0x010101U);
  for (int row = mat.rows - 1; row >= 0; --row) {
    const std::size_t end = bytes.size() + line;
    bytes.insert(bytes.end(), mat.ptr(row),
                 mat.ptr(row) + mat.elemSize() * static_cast<std::size_t>(mat.cols));
    bytes.resize(end);
  }
  return bytes;
}

cv::Mat read_pgm(Bytes bytes) {
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const char kind = text[1];
  text.remove_prefix(2);
  const auto columns = next_number(text), rows = next_number(text), levels = next_number(text);
  const bool binary = kind == '5' || kind == '6', coloured = kind == '3' || kind == '6';
  if (kind == '1' || kind == '4')
    throw Error("a picture of one bit a pixel; grey levels are wanted");
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
  cv::Mat mat(static_cast<int>(*rows), static_cast<int>(*columns),
              CV_MAKETYPE(wide == 2 ? CV_16U : CV_8U, static_cast<int>(channels)));
  for (std::size_t i = 0; i < numbers; ++i) {
    std::uint32_t value = 0;
    if (binary) {
      for (std::size_t byte = 0; byte < wide; ++byte) {
        value = value << 8 | static_cast<std::uint8_t>(text[i * wide + byte]);
      }
    } else {
      const auto number = next_number(text);
      if (!number || *number > *levels) throw Error("not a whole PGM file: truncated");
      value = *number;
    }
    if (wide == 2) mat.ptr<std::uint16_t>()[i] = static_cast<std::uint16_t>(value);
    if (wide == 1) mat.ptr()[i] = static_cast<std::uint8_t>(value);
  }
  if (coloured) cv::cvtColor(mat, mat, cv::COLOR_RGB2BGR);
  return mat;
}

std::vector<std::uint8_t> pgm_file_of(const cv::Mat& mat) {
  if (mat.type() != CV_8UC1 && mat.type() != CV_16UC1) return {};
  const std::string header =
      fmt::format("P5\n{} {}\n{}\n", mat.cols, mat.rows, mat.type() == CV_8UC1 ? 255 : 65535);
  std::vector<std::uint8_t> bytes(header.begin(), header.end());
  for (int row = 0; row < mat.rows; ++row) {
    for (int column = 0; column < mat.cols; ++column) {
      if (mat.type() == CV_8UC1) {
        bytes.push_back(mat.at<std::uint8_t>(row, column));
      } else {
        const std::uint16_t value = mat.at<std::uint16_t>(row, column);
        bytes.insert(bytes.end(),
                     {static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)});
      }
    }
  }
  return bytes;
}

}  // namespace slipstream
