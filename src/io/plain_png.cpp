// Most PNG files: grey or RGB of 8 or 16 bits, not interlaced. libdeflate unpacks them half again
// as fast as libpng does.
#include "io/plain_png.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <libdeflate.h>

#include "base/numbers.h"
#include "io/file.h"
#include "io/pictures.h"

namespace slipstream {
namespace {

constexpr std::size_t signature = 8, chunk_head = 8, chunk_end = 4;

std::uint32_t big_endian(std::span<const std::uint8_t> bytes, std::size_t at) {
  return number_at<std::uint32_t, std::endian::big>(bytes, at);
}

/// The compressed samples; nullopt unless all chunks are whole and in order.
std::optional<std::vector<std::uint8_t>> packed_samples(std::span<const std::uint8_t> file) {
  std::vector<std::uint8_t> packed;
  packed.reserve(file.size());

  bool is_complete = false;  // something follows the samples

  // A chunk: its length, its kind, that many bytes, and a checksum of kind and bytes.
  for (std::size_t at = signature; file.size() - at >= chunk_head + chunk_end;) {
    const std::size_t length = big_endian(file, at);
    if (length > file.size() - at - chunk_head - chunk_end) return std::nullopt;

    const auto chunk = file.subspan(at + 4, 4 + length);
    if (checksum(chunk) != big_endian(file, at + chunk_head + length)) return std::nullopt;

    const std::string_view kind(reinterpret_cast<const char*>(chunk.data()), 4);
    if (kind == "IEND") return packed;

    if (kind == "IDAT" && !is_complete) {
      packed.insert(packed.end(), chunk.begin() + 4, chunk.end());
    } else if (!packed.empty()) {
      is_complete = true;
      if (kind == "IDAT") return std::nullopt;
    }

    at += chunk_head + length + chunk_end;
  }

  return std::nullopt;
}

/// The one of left, above and corner that is closest to left + above - corner.
int closest(int left, int above, int corner) {
  // Distances to the prediction left + above - corner.
  const int by_left = std::abs(above - corner), by_above = std::abs(left - corner),
            by_corner = std::abs(left + above - 2 * corner);

  if (by_left <= by_above && by_left <= by_corner) return left;
  return by_above <= by_corner ? above : corner;
}

/// Adds to each byte its prediction from the bytes to the left, above and in the corner between.
template <std::size_t pixel, class Predict>
void add_predicted(std::span<std::uint8_t> row, const std::uint8_t* above, Predict predict) {
  std::array<std::uint8_t, pixel> left{}, corner{};
  for (std::size_t i = 0; i < row.size(); i += pixel) {
    for (std::size_t c = 0; c < pixel; ++c) {
      left[c] = static_cast<std::uint8_t>(row[i + c] + predict(left[c], above[i + c], corner[c]));
      corner[c] = above[i + c];
      row[i + c] = left[c];
    }
  }
}

/// Undoes the filter of a row, given the row above. `pixel`: bytes of one. False: no such filter.
template <std::size_t pixel>
bool undo_filter(int filter, std::span<std::uint8_t> row, const std::uint8_t* above) {
  const auto undo = [&](auto predict) { add_predicted<pixel>(row, above, predict); };

  // The filters of the PNG standard: left, above, mean of both, and Paeth's. 0 is none.
  if (filter == 1) undo([](int left, int, int) { return left; });
  if (filter == 2) undo([](int, int up, int) { return up; });
  if (filter == 3) undo([](int left, int up, int) { return (left + up) / 2; });
  if (filter == 4) undo(closest);

  return filter <= 4;
}

}  // namespace

std::optional<Picture> read_plain_png(std::span<const std::uint8_t> file, std::size_t frames) {
  // 1. The header, which is always the first chunk.
  constexpr std::string_view begin("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
  constexpr std::size_t header = 13, largest_side = 1'000'000;
  if (file.size() < begin.size() + header ||
      !std::equal(begin.begin(), begin.end(), reinterpret_cast<const char*>(file.data()))) {
    return std::nullopt;
  }

  const std::size_t columns = big_endian(file, 16), rows = big_endian(file, 20);

  const int bits = file[24], colour = file[25];
  const bool is_plain = (bits == 8 || bits == 16) && (colour == 0 || colour == 2) &&
                        file[26] == 0 && file[27] == 0 && file[28] == 0;

  // For 0 columns or rows, the difference is the largest number.
  if (!is_plain || columns - 1 >= largest_side || rows - 1 >= largest_side) return std::nullopt;

  const PictureKind kind{
      {static_cast<int>(columns), static_cast<int>(rows)}, colour == 0 ? 1 : 3, bits};
  const std::size_t row_bytes = kind.row_bytes();
  require_readable(columns * rows, frames, bits);
  require_held(row_bytes * rows, file.size(), deflate_factor);

  const std::optional<std::vector<std::uint8_t>> packed = packed_samples(file);
  if (!packed) return std::nullopt;

  // 2. Unpacks the samples. Each row begins with the number of its filter.
  Picture picture(kind);
  auto* const unfilter = colour == 0 ? (bits == 8 ? undo_filter<1> : undo_filter<2>)
                                     : (bits == 8 ? undo_filter<3> : undo_filter<6>);

  const auto unpacked = std::make_unique_for_overwrite<std::uint8_t[]>((row_bytes + 1) * rows);

  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> unpacker(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);

  if (unpacker == nullptr ||
      libdeflate_zlib_decompress(unpacker.get(), packed->data(), packed->size(), unpacked.get(),
                                 (row_bytes + 1) * rows, nullptr) != LIBDEFLATE_SUCCESS) {
    return std::nullopt;
  }

  // 3. Undoes the filters, row by row. The row above the first counts as 0.
  const std::vector<std::uint8_t> nothing(row_bytes);
  const std::uint8_t* above = nothing.data();

  for (std::size_t n = 0; n < rows; ++n) {
    std::uint8_t* const row = unpacked.get() + n * (row_bytes + 1) + 1;
    if (!unfilter(row[-1], {row, row_bytes}, above)) return std::nullopt;
    above = row;

    // 16-bit samples are stored with the high byte first.
    std::uint8_t* const to = picture.row(static_cast<int>(n));
    for (std::size_t i = 0; bits == 16 && i < row_bytes; i += 2) {
      to[i] = row[i + 1];
      to[i + 1] = row[i];
    }
    if (bits == 8) std::memcpy(to, row, row_bytes);
  }

  return picture;
}

}  // namespace slipstream
