#include "slipstream/io/detail/tiff_file.h"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <string>

#include <fcntl.h>
#include <opencv2/imgproc.hpp>
#include <tiffio.h>

#include "slipstream/base/error.h"
#include "slipstream/io/limits.h"

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

/// The type of cv::Mat that the pixels have; -1 for any other.
int type_of(TIFF* tiff) {
  const auto bits = field<std::uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE);
  const auto samples = field<std::uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL);
  const auto format = field<std::uint16_t>(tiff, TIFFTAG_SAMPLEFORMAT);
  std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
  const bool whole = format == SAMPLEFORMAT_UINT && (bits == 8 || bits == 16);
  const bool real = format == SAMPLEFORMAT_IEEEFP && (bits == 32 || bits == 64);
  const bool grey = samples == 1 && photometric == PHOTOMETRIC_MINISBLACK;
  const bool coloured = photometric == PHOTOMETRIC_RGB && (samples == 3 || samples == 4) &&
                        field<std::uint16_t>(tiff, TIFFTAG_PLANARCONFIG) == PLANARCONFIG_CONTIG;
  if (whole && (grey || coloured)) return CV_MAKETYPE(bits == 8 ? CV_8U : CV_16U, samples);
  return real && grey ? (bits == 32 ? CV_32FC1 : CV_64FC1) : -1;
}

/// The directory as libtiff understands it need not be what stated_pixels sees.
bool is_too_large(std::uint64_t width, std::uint64_t height) {
  return width > largest_picture / height;
}

bool read_tiles(TIFF* tiff, cv::Mat& mat) {
  const auto width = static_cast<int>(field<std::uint32_t>(tiff, TIFFTAG_TILEWIDTH));
  const auto height = static_cast<int>(field<std::uint32_t>(tiff, TIFFTAG_TILELENGTH));
  if (width < 1 || height < 1 || is_too_large(width, height)) return false;
  cv::Mat tile(height, width, mat.type());
  if (TIFFTileSize64(tiff) != tile.total() * tile.elemSize()) return false;
  for (int y = 0; y < mat.rows; y += height) {
    for (int x = 0; x < mat.cols; x += width) {
      if (TIFFReadTile(tiff, tile.data, static_cast<std::uint32_t>(x),
                       static_cast<std::uint32_t>(y), 0, 0) < 0) {
        return false;
      }
      const cv::Rect inside(0, 0, std::min(width, mat.cols - x), std::min(height, mat.rows - y));
      tile(inside).copyTo(mat(inside + cv::Point(x, y)));
    }
  }
  return true;
}

bool read_lines(TIFF* tiff, cv::Mat& mat) {
  const std::uint64_t bytes = static_cast<std::uint64_t>(mat.cols) * mat.elemSize();
  if (TIFFScanlineSize64(tiff) != bytes) return false;
  for (int row = 0; row < mat.rows; ++row) {
    if (TIFFReadScanline(tiff, mat.ptr(row), static_cast<std::uint32_t>(row), 0) < 0) return false;
  }
  return true;
}

/// Where there is no more memory: closing must not write on without what was not had.
[[noreturn]] void give_up(TIFF* tiff) {
  TIFFSetMode(tiff, O_RDONLY);
  throw std::bad_alloc();
}

/// Colours in the other order.
cv::Mat turned(const cv::Mat& mat) {
  cv::Mat other = mat;
  if (mat.channels() == 3) cv::cvtColor(mat, other, cv::COLOR_RGB2BGR);
  if (mat.channels() == 4) cv::cvtColor(mat, other, cv::COLOR_RGBA2BGRA);
  return other;
}

}  // namespace

cv::Mat read_tiff(std::span<const std::uint8_t> bytes) {
  Memory memory{.read = bytes, .written = {}};
  const Tiff tiff = open_tiff(memory, "rm");
  if (tiff == nullptr) refuse(memory);
  const auto width = field<std::uint32_t>(tiff.get(), TIFFTAG_IMAGEWIDTH);
  const auto height = field<std::uint32_t>(tiff.get(), TIFFTAG_IMAGELENGTH);
  if (width < 1 || height < 1) refuse(memory);
  if (is_too_large(width, height)) throw Error("it has too many pixels");
  const int type = type_of(tiff.get());
  if (type < 0) throw Error("pixels of an unknown kind; grey of 8 or 16 bits or float is wanted");
  cv::Mat mat(static_cast<int>(height), static_cast<int>(width), type);
  const bool whole =
      TIFFIsTiled(tiff.get()) != 0 ? read_tiles(tiff.get(), mat) : read_lines(tiff.get(), mat);
  if (!whole) refuse(memory);
  return turned(mat);
}

std::vector<std::uint8_t> tiff_file_of(const cv::Mat& mat) {
  Memory memory{.read = {}, .written = {}};
  Tiff tiff = open_tiff(memory, "w");
  if (tiff == nullptr) throw std::bad_alloc();
  const bool real = mat.depth() == CV_32F || mat.depth() == CV_64F;
  const cv::Mat pixels = turned(mat);
  TIFFSetField(tiff.get(), TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(mat.cols));
  TIFFSetField(tiff.get(), TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(mat.rows));
  TIFFSetField(tiff.get(), TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * mat.elemSize1()));
  TIFFSetField(tiff.get(), TIFFTAG_SAMPLESPERPIXEL, mat.channels());
  TIFFSetField(tiff.get(), TIFFTAG_SAMPLEFORMAT, real ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT);
  TIFFSetField(tiff.get(), TIFFTAG_PHOTOMETRIC,
               mat.channels() == 1 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB);
  TIFFSetField(tiff.get(), TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff.get(), TIFFTAG_COMPRESSION, COMPRESSION_LZW);
  if (!real) TIFFSetField(tiff.get(), TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
  TIFFSetField(tiff.get(), TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff.get(), 0));
  if (memory.fault.front() != 0) give_up(tiff.get());
  std::vector<std::uint8_t> line(static_cast<std::size_t>(mat.cols) * mat.elemSize());
  for (int row = 0; row < mat.rows; ++row) {
    // A predictor changes the line that it is given.
    std::copy_n(pixels.ptr(row), line.size(), line.begin());
    if (TIFFWriteScanline(tiff.get(), line.data(), static_cast<std::uint32_t>(row), 0) < 0) {
      give_up(tiff.get());  // nothing else can fail in memory
    }
  }
  tiff.reset();  // writes the directory
  if (memory.fault.front() != 0) throw std::bad_alloc();
  return std::move(memory.written);
}

}  // namespace slipstream
