#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <type_traits>

#include <fcntl.h>
#include <tiffio.h>

#include "slipstream/base/error.h"
#include "slipstream/io/detail/pictures.h"
#include "slipstream/io/file.h"

namespace slipstream {
namespace {

/// A file in memory, and what libtiff first said against it. Nothing is thrown through libtiff.
struct Memory {
  std::span<const std::uint8_t> read;
  std::vector<std::uint8_t> written;
  std::uint64_t at = 0;
  std::array<char, 160> fault{};

  [[nodiscard]] std::uint64_t size() const { return std::max(read.size(), written.size()); }
};

Memory& memory_of(thandle_t handle) {
  return *static_cast<Memory*>(handle);
}

tmsize_t take(thandle_t handle, void* to, tmsize_t count) {
  Memory& file = memory_of(handle);
  // What is being written is read again only by libtiff's own directory.
  const std::span<const std::uint8_t> from = file.written.empty() ? file.read : file.written;
  const std::uint64_t left = file.at < from.size() ? from.size() - file.at : 0;
  const std::uint64_t taken = std::min(left, static_cast<std::uint64_t>(count));
  if (taken > 0) std::memcpy(to, from.data() + file.at, taken);
  file.at += taken;
  return static_cast<tmsize_t>(taken);
}

tmsize_t put(thandle_t handle, void* from, tmsize_t count) try {
  Memory& file = memory_of(handle);
  const auto bytes = static_cast<std::uint64_t>(count);
  if (file.written.size() < file.at + bytes) file.written.resize(file.at + bytes);
  std::memcpy(&file.written[file.at], from, bytes);
  file.at += bytes;
  return count;
} catch (const std::bad_alloc&) {
  return -1;
}

toff_t seek(thandle_t handle, toff_t by, int whence) {
  Memory& file = memory_of(handle);
  file.at = by + (whence == SEEK_CUR ? file.at : whence == SEEK_END ? file.size() : 0);
  return file.at;
}

int close_memory(thandle_t) {
  return 0;
}

toff_t size_of(thandle_t handle) {
  return memory_of(handle).size();
}

int keep_fault(TIFF*, void* memory, const char*, const char* format, va_list values) {
  std::array<char, 160>& fault = static_cast<Memory*>(memory)->fault;
  if (fault.front() == 0) std::vsnprintf(fault.data(), fault.size(), format, values);
  return 1;
}

int say_nothing(TIFF*, void*, const char*, const char*, va_list) {
  return 1;
}

using Tiff = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

Tiff open_tiff(Memory& memory, const char* mode) {
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(
      TIFFOpenOptionsAlloc(), TIFFOpenOptionsFree);
  if (options == nullptr) throw std::bad_alloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_fault, &memory);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), say_nothing, nullptr);
  return {TIFFClientOpenExt("memory", mode, &memory, take, put, seek, close_memory, size_of,
                            nullptr, nullptr, options.get()),
          TIFFClose};
}

[[noreturn]] void refuse(const Memory& memory) {
  const std::string fault = memory.fault.data();
  throw Error("not a whole TIFF file" + (fault.empty() ? "" : ": " + fault));
}

template <class Number>
Number field(TIFF* tiff, std::uint32_t tag) {
  Number value = 0;
  TIFFGetFieldDefaulted(tiff, tag, &value);
  return value;
}

/// Of those pixels, whose samples are not read yet; none where they are of another kind.
std::optional<Picture> empty_picture(TIFF* tiff, int width, int height) {
  const auto bits = field<std::uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE);
  const auto samples = field<std::uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL);
  const auto format = field<std::uint16_t>(tiff, TIFFTAG_SAMPLEFORMAT);
  std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
  const bool whole = format == SAMPLEFORMAT_UINT, real = format == SAMPLEFORMAT_IEEEFP;
  const bool grey = samples == 1 && photometric == PHOTOMETRIC_MINISBLACK;
  const bool coloured = photometric == PHOTOMETRIC_RGB && (samples == 3 || samples == 4) &&
                        field<std::uint16_t>(tiff, TIFFTAG_PLANARCONFIG) == PLANARCONFIG_CONTIG;
  const auto of = [&]<class Sample>(Sample) {
    return Picture{Image<Sample>({width * samples, height}, uninitialised), samples};
  };
  if (whole && bits == 8 && (grey || coloured)) return of(std::uint8_t{});
  if (whole && bits == 16 && (grey || coloured)) return of(std::uint16_t{});
  if (real && bits == 32 && grey) return of(float{});
  if (real && bits == 64 && grey) return of(double{});
  return std::nullopt;
}

/// Rows of bytes in the memory of the samples.
ImageView<std::uint8_t> sample_bytes(Picture& picture) {
  return std::visit(
      []<class Sample>(Image<Sample>& samples) -> ImageView<std::uint8_t> {
        return {reinterpret_cast<std::uint8_t*>(samples.begin()),
                {samples.width() * static_cast<int>(sizeof(Sample)), samples.height()}};
      },
      picture.samples);
}

/// The directory as libtiff understands it need not be what tiff_pixels sees.
bool is_too_large(std::uint64_t width, std::uint64_t height) {
  return width > largest_picture / height;
}

/// `pixel`: bytes of one.
bool read_tiles(TIFF* tiff, const ImageView<std::uint8_t>& rows, std::uint64_t pixel) {
  const auto width = field<std::uint32_t>(tiff, TIFFTAG_TILEWIDTH);
  const auto height = field<std::uint32_t>(tiff, TIFFTAG_TILELENGTH);
  if (width < 1 || height < 1 || is_too_large(width, height)) return false;
  const std::uint64_t line = width * pixel;
  if (TIFFTileSize64(tiff) != line * height) return false;
  std::vector<std::uint8_t> tile(line * height);
  const auto bytes = static_cast<std::uint64_t>(rows.width());
  const auto row_count = static_cast<std::uint32_t>(rows.height());
  for (std::uint32_t y = 0; y < row_count; y += height) {
    for (std::uint64_t x = 0; x < bytes; x += line) {
      const auto column = static_cast<std::uint32_t>(x / pixel);
      if (TIFFReadTile(tiff, tile.data(), column, y, 0, 0) < 0) return false;
      for (std::uint32_t row = 0; row < std::min(height, row_count - y); ++row) {
        std::memcpy(rows.row(static_cast<int>(y + row)) + x, &tile[row * line],
                    std::min(line, bytes - x));
      }
    }
  }
  return true;
}

bool read_lines(TIFF* tiff, const ImageView<std::uint8_t>& rows) {
  if (TIFFScanlineSize64(tiff) != static_cast<std::uint64_t>(rows.width())) return false;
  for (int row = 0; row < rows.height(); ++row) {
    if (TIFFReadScanline(tiff, rows.row(row), static_cast<std::uint32_t>(row), 0) < 0) return false;
  }
  return true;
}

/// Where there is no more memory: closing must not write on without what was not had.
[[noreturn]] void give_up(TIFF* tiff) {
  TIFFSetMode(tiff, O_RDONLY);
  throw std::bad_alloc();
}

/// Of the first directory: the widths and heights of picture and tiles.
std::uint64_t stated_pixels(const HeaderNumbers& number) {
  const bool big = number(2, 2) == 43;
  const std::uint64_t word = big ? 8 : 4, entry = big ? 20 : 12;
  const std::uint64_t directory = number(word, word), of_count = big ? 8 : 2;
  std::array<std::uint64_t, 2> picture{}, tile{};
  for (std::uint64_t n = number(directory, of_count), at = directory + of_count;
       n > 0 && at < number.bytes.size(); --n, at += entry) {
    const std::uint64_t type = number(at + 2, 2);
    const bool is_short = type == 3 || type == 8, is_byte = type == 1 || type == 6;
    const std::uint64_t size = is_byte ? 1 : is_short ? 2 : type < 16 ? 4 : 8;
    const std::uint64_t value = number(at + 4 + word, size);
    const std::uint64_t tag = number(at, 2);
    if (tag == 256 || tag == 257) picture[tag - 256] = std::max(picture[tag - 256], value);
    if (tag == 322 || tag == 323) tile[tag - 322] = std::max(tile[tag - 322], value);
  }
  const auto pixels = [](const auto& sides) {
    return std::min(sides[0], std::uint64_t{1} << 31) * std::min(sides[1], std::uint64_t{1} << 31);
  };
  return std::max(pixels(picture), pixels(tile));
}

}  // namespace

std::uint64_t tiff_pixels(std::span<const std::uint8_t> bytes) {
  return stated_pixels({bytes, bytes[0] == 'I'});
}

Picture read_tiff(std::span<const std::uint8_t> bytes) {
  Memory memory{.read = bytes, .written = {}};
  const Tiff tiff = open_tiff(memory, "rm");
  if (tiff == nullptr) refuse(memory);
  const auto width = field<std::uint32_t>(tiff.get(), TIFFTAG_IMAGEWIDTH);
  const auto height = field<std::uint32_t>(tiff.get(), TIFFTAG_IMAGELENGTH);
  if (width < 1 || height < 1) refuse(memory);
  if (is_too_large(width, height)) throw Error("it has too many pixels");
  std::optional<Picture> picture =
      empty_picture(tiff.get(), static_cast<int>(width), static_cast<int>(height));
  if (!picture) throw Error("pixels of an unknown kind; grey of 8 or 16 bits or float is wanted");
  const ImageView<std::uint8_t> rows = sample_bytes(*picture);
  const bool whole =
      TIFFIsTiled(tiff.get()) != 0
          ? read_tiles(tiff.get(), rows, static_cast<std::uint64_t>(rows.width()) / width)
          : read_lines(tiff.get(), rows);
  if (!whole) refuse(memory);
  return *std::move(picture);
}

std::vector<std::uint8_t> tiff_file_of(const PictureView& picture) {
  Memory memory{.read = {}, .written = {}};
  Tiff tiff = open_tiff(memory, "w");
  if (tiff == nullptr) throw std::bad_alloc();
  std::visit(
      [&]<class Sample>(const ImageView<const Sample>& samples) {
        constexpr bool real = std::is_floating_point_v<Sample>;
        const auto set = [&](std::uint32_t tag, auto value) {
          TIFFSetField(tiff.get(), tag, value);
        };
        set(TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(picture.size().width));
        set(TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(samples.height()));
        set(TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * sizeof(Sample)));
        set(TIFFTAG_SAMPLESPERPIXEL, picture.channels);
        set(TIFFTAG_SAMPLEFORMAT, real ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT);
        set(TIFFTAG_PHOTOMETRIC, picture.channels == 1 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB);
        set(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
        set(TIFFTAG_COMPRESSION, COMPRESSION_LZW);
        if (!real) set(TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
        set(TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff.get(), 0));
        if (memory.fault.front() != 0) give_up(tiff.get());
        for (int row = 0; row < samples.height(); ++row) {
          // A predictor changes the line that it is given.
          std::vector<Sample> line(samples.row(row), samples.row(row) + samples.width());
          if (TIFFWriteScanline(tiff.get(), line.data(), static_cast<std::uint32_t>(row), 0) < 0) {
            give_up(tiff.get());  // nothing else can fail in memory
          }
        }
      },
      picture.samples);
  tiff.reset();  // writes the directory
  if (memory.fault.front() != 0) throw std::bad_alloc();
  return std::move(memory.written);
}

}  // namespace slipstream
