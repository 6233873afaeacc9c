// Losslessly compressed pictures: PNG by libpng, TIFF by libtiff. No exception passes through
// either library.
#include "io/compressed_pictures.h"

#include <algorithm>
#include <array>
#include <bit>
#include <csetjmp>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include <fcntl.h>
#include <png.h>
#include <tiffio.h>

#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/pictures.h"
#include "io/plain_png.h"
#include "io/tiff_directories.h"

namespace slipstream {
namespace {

/// A file to read, or one written in memory, and the library's first error message.
struct FileInMemory {
  std::span<const std::uint8_t> read{};
  const InputFile* input = nullptr;    ///< instead of `read`
  std::vector<std::uint8_t> header{};  ///< instead of the first bytes of `input`
  std::exception_ptr input_failure{};  ///< if reading `input` threw
  std::vector<std::uint8_t> written{};
  std::uint64_t at = 0;
  bool is_full = false;
  std::array<char, 160> fault{};

  [[nodiscard]] std::uint64_t size() const {
    return input != nullptr ? input->size() : std::max(read.size(), written.size());
  }
};

void take_png(png_structp png, png_bytep to, std::size_t count) {
  auto& file = *static_cast<FileInMemory*>(png_get_io_ptr(png));
  if (count > file.read.size() - file.at) png_error(png, "truncated");

  std::copy_n(file.read.data() + file.at, count, to);
  file.at += count;
}

void put_png(png_structp png, png_bytep from, std::size_t count) {
  auto& memory = *static_cast<FileInMemory*>(png_get_io_ptr(png));
  try {
    if (!memory.is_full) memory.written.insert(memory.written.end(), from, from + count);
  } catch (const std::bad_alloc&) {
    memory.is_full = true;
  }
}

[[noreturn]] void refuse_png(png_structp png, png_const_charp why) {
  auto& fault = static_cast<FileInMemory*>(png_get_error_ptr(png))->fault;
  std::string_view(why).copy(fault.data(), fault.size() - 1);
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

/// libpng's state for reading one file.
struct PngReader {
  explicit PngReader(FileInMemory& memory)
      : png(png_create_read_struct(PNG_LIBPNG_VER_STRING, &memory, refuse_png, ignore_warning)),
        info(png_create_info_struct(png)) {
    png_set_read_fn(png, &memory, take_png);
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }

  png_structp png;
  png_infop info;
};

/// False if libpng fails: it jumps back here, skipping no destructors.
bool read_png_rows(png_structp png, png_infop info, std::size_t file_bytes, std::size_t frames,
                   std::optional<Picture>& picture) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;

  // Texts and colour profiles may unpack a thousandfold, for nothing.
  constexpr std::array<png_byte, 25> unread{"tEXt\0zTXt\0iTXt\0iCCP\0sPLT"};
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, unread.data(), 5);

  png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
  png_read_info(png, info);

  // The limit of pixels, before memory is allocated.
  const std::uint64_t columns = png_get_image_width(png, info);
  const std::uint64_t rows = png_get_image_height(png, info);
  require_readable(columns * rows, frames);
  require_held(png_get_rowbytes(png, info) * rows, file_bytes, deflate_factor);

  // Samples of at least 8 bits in the machine's byte order, without palette and alpha.
  png_set_palette_to_rgb(png);
  png_set_expand_gray_1_2_4_to_8(png);
  png_set_strip_alpha(png);
  if (std::endian::native == std::endian::little) png_set_swap(png);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);

  const Size size{static_cast<int>(columns), static_cast<int>(rows)};
  picture.emplace(PictureKind{size, png_get_channels(png, info), png_get_bit_depth(png, info)});

  // An interlaced picture is refined in several passes over all rows.
  for (int row = 0; row < passes * size.height; ++row) {
    png_read_row(png, picture->row(row % size.height), nullptr);
  }

  png_read_end(png, nullptr);
  return true;
}

/// Stops if libpng fails. Samples below 8 bits take one byte each.
void write_png_rows(png_structp png, png_infop info, const PictureView& picture, int bits) {
  if (setjmp(png_jmpbuf(png)) != 0) return;

  const auto& [size, channels, bits_in_memory] = picture.kind;
  png_set_IHDR(png, info, static_cast<png_uint_32>(size.width),
               static_cast<png_uint_32>(size.height), bits,
               channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE);

  // Half the size of no compression, in a fifth of the time of the best.
  png_set_compression_level(png, 2);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, bits < 8 ? PNG_FILTER_NONE : PNG_FILTER_SUB);

  png_write_info(png, info);
  png_set_packing(png);
  if (std::endian::native == std::endian::little) png_set_swap(png);

  for (int row = 0; row < size.height; ++row) png_write_row(png, picture.row(row));
  png_write_end(png, nullptr);
}

std::vector<std::uint8_t> png_of_depth(const PictureView& picture, int bits) {
  FileInMemory memory;
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, &memory, refuse_png, ignore_warning);
  png_infop info = png_create_info_struct(png);
  memory.is_full = info == nullptr;

  png_set_write_fn(png, &memory, put_png, nullptr);
  if (!memory.is_full) write_png_rows(png, info, picture, bits);
  png_destroy_write_struct(&png, &info);

  // An exception is thrown only here, after libpng has returned.
  if (memory.is_full) throw std::bad_alloc();
  if (memory.fault.front() != 0) throw Error(std::string("not a PNG file: ") + memory.fault.data());

  return std::move(memory.written);
}

FileInMemory& memory_of(thandle_t handle) {
  return *static_cast<FileInMemory*>(handle);
}

tmsize_t take(thandle_t handle, void* to, tmsize_t count) try {
  FileInMemory& file = memory_of(handle);
  const std::uint64_t left = file.at < file.size() ? file.size() - file.at : 0;
  const std::uint64_t taken = std::min(left, static_cast<std::uint64_t>(count));

  if (file.input == nullptr) {  // while writing, libtiff reads back only its own directory
    if (taken > 0) std::memcpy(to, file.written.data() + file.at, taken);
  } else if (!file.input->read(file.at, {{static_cast<std::uint8_t*>(to), taken}})) {
    return -1;
  }

  for (std::uint64_t at = file.at; at < std::min(file.at + taken, file.header.size()); ++at) {
    static_cast<std::uint8_t*>(to)[at - file.at] = file.header[at];
  }

  file.at += taken;
  return static_cast<tmsize_t>(taken);
} catch (...) {
  memory_of(handle).input_failure = std::current_exception();
  return -1;
}

tmsize_t put(thandle_t handle, void* from, tmsize_t count) try {
  FileInMemory& file = memory_of(handle);
  const auto bytes = static_cast<std::uint64_t>(count);

  // libtiff also overwrites earlier parts.
  if (file.written.size() < file.at + bytes) file.written.resize(file.at + bytes);
  std::memcpy(file.written.data() + file.at, from, bytes);
  file.at += bytes;
  return count;
} catch (const std::bad_alloc&) {
  return -1;
}

toff_t seek(thandle_t handle, toff_t by, int whence) {
  FileInMemory& file = memory_of(handle);
  file.at = by + (whence == SEEK_CUR ? file.at : whence == SEEK_END ? file.size() : 0);
  return file.at;
}

int keep_fault(TIFF*, void* memory, const char*, const char* format, va_list values) {
  std::array<char, 160>& fault = static_cast<FileInMemory*>(memory)->fault;
  if (fault.front() == 0) std::vsnprintf(fault.data(), fault.size(), format, values);
  return 1;
}

using Tiff = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

Tiff open_tiff(FileInMemory& memory, const char* mode) {
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(
      TIFFOpenOptionsAlloc(), TIFFOpenOptionsFree);
  if (options == nullptr) throw std::bad_alloc();

  // Keeps the first error and ignores warnings, instead of printing them.
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_fault, &memory);
  TIFFOpenOptionsSetWarningHandlerExtR(
      options.get(), [](TIFF*, void*, const char*, const char*, va_list) { return 1; }, nullptr);

  const auto close = [](thandle_t) { return 0; };
  const auto size = [](thandle_t handle) -> toff_t { return memory_of(handle).size(); };

  return {TIFFClientOpenExt("memory", mode, &memory, take, put, seek, close, size, nullptr, nullptr,
                            options.get()),
          TIFFClose};
}

template <class Number>
Number field(TIFF* tiff, std::uint32_t tag) {
  Number value = 0;
  TIFFGetFieldDefaulted(tiff, tag, &value);
  return value;
}

/// Most bytes that a picture's compression packs into one; any number for rare ones.
std::uint64_t factor_of(TIFF* tiff) {
  constexpr std::uint64_t packed_bits = 64, lzw = 4096;
  switch (field<std::uint16_t>(tiff, TIFFTAG_COMPRESSION)) {
    case COMPRESSION_NONE:
      return 1;
    case COMPRESSION_PACKBITS:
      return packed_bits;
    case COMPRESSION_LZW:
      return lzw;
    case COMPRESSION_DEFLATE:
    case COMPRESSION_ADOBE_DEFLATE:
      return deflate_factor;
    default:
      return largest_picture * 64;
  }
}

std::uint16_t photometric_of(TIFF* tiff) {
  std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
  return photometric;
}

/// The layout of a picture of that size. Throws Error for other sample types.
PictureKind kind_of(TIFF* tiff, Size size) {
  const auto samples = field<std::uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL);
  const auto format = field<std::uint16_t>(tiff, TIFFTAG_SAMPLEFORMAT);

  const std::uint16_t photometric = photometric_of(tiff);
  const bool inverted = photometric == PHOTOMETRIC_MINISWHITE;
  const bool grey = samples == 1 && (photometric == PHOTOMETRIC_MINISBLACK || inverted);
  const bool coloured = photometric == PHOTOMETRIC_RGB && (samples == 3 || samples == 4) &&
                        field<std::uint16_t>(tiff, TIFFTAG_PLANARCONFIG) == PLANARCONFIG_CONTIG;

  const PictureKind kind{size, samples, field<std::uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE)};
  const bool whole = format == SAMPLEFORMAT_UINT && (kind.bits == 8 || kind.bits == 16);
  const bool real = format == SAMPLEFORMAT_IEEEFP && (kind.bits == 32 || kind.bits == 64);

  if ((whole && (grey || coloured)) || (real && grey && !inverted)) return kind;
  throw Error("unsupported pixel type; expected grey of 8 or 16 bits, or float");
}

/// Inverts a picture of whole numbers whose 0 is white.
void invert_levels(Picture& picture) {
  std::visit(
      []<class Sample>(Image<Sample>& samples) {
        if constexpr (std::is_integral_v<Sample>) {
          constexpr Sample white = std::numeric_limits<Sample>::max();
          for (Sample& sample : samples) sample = static_cast<Sample>(white - sample);
        }
      },
      picture.samples);
}

/// Checks the size of a picture or tile before allocating memory.
Size size_of(TIFF* tiff, std::uint32_t width_tag, std::uint32_t height_tag, std::size_t frames) {
  const auto width = field<std::uint32_t>(tiff, width_tag);
  const auto height = field<std::uint32_t>(tiff, height_tag);

  require_readable(std::uint64_t{width} * height, frames);
  return {static_cast<int>(width), static_cast<int>(height)};
}

bool read_tiles(TIFF* tiff, Picture& picture, std::size_t frames) {
  const auto [width, height] = size_of(tiff, TIFFTAG_TILEWIDTH, TIFFTAG_TILELENGTH, frames);
  if (width < 1 || height < 1) return false;

  // Each tile is unpacked whole, so tiles may not reach far beyond the picture.
  const Size size = picture.kind.size;
  const double tile_pixels = 1.0 * width * height, pixels = 1.0 * size.width * size.height;
  throw_if(tile_pixels > std::max(4 * pixels, 0x1p20),
           "its tiles of {} are larger than the picture", text_of(Size{width, height}));

  const PictureKind tile_kind{{width, height}, picture.kind.channels, picture.kind.bits};
  const std::size_t line = tile_kind.row_bytes(), pixel = line / static_cast<std::size_t>(width);
  if (TIFFTileSize64(tiff) != line * static_cast<std::size_t>(height)) return false;

  std::vector<std::uint8_t> tile(line * static_cast<std::size_t>(height));
  for (int y = 0; y < size.height; y += height) {
    for (int x = 0; x < size.width; x += width) {
      if (TIFFReadTile(tiff, tile.data(), static_cast<std::uint32_t>(x),
                       static_cast<std::uint32_t>(y), 0, 0) < 0) {
        return false;
      }

      // Tiles at the right and lower edges reach beyond the picture.
      const std::size_t columns = static_cast<std::size_t>(std::min(width, size.width - x));
      for (int row = 0; row < std::min(height, size.height - y); ++row) {
        std::memcpy(picture.row(y + row) + static_cast<std::size_t>(x) * pixel,
                    &tile[static_cast<std::size_t>(row) * line], columns * pixel);
      }
    }
  }

  return true;
}

bool read_lines(TIFF* tiff, Picture& picture) {
  if (TIFFScanlineSize64(tiff) != picture.kind.row_bytes()) return false;

  for (int row = 0; row < picture.kind.size.height; ++row) {
    if (TIFFReadScanline(tiff, picture.row(row), static_cast<std::uint32_t>(row), 0) < 0) {
      return false;
    }
  }
  return true;
}

void require(bool whole, const FileInMemory& memory) {
  if (memory.input_failure) std::rethrow_exception(memory.input_failure);
  const std::string fault = memory.fault.data();
  if (!whole) throw Error("incomplete TIFF file" + (fault.empty() ? "" : ": " + fault));
}

/// Whether ImageJ stored `images=N` pictures behind one directory, as it does above 4 GB.
bool hides_pages(TIFF* tiff) {
  const char* text = nullptr;
  return TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &text) == 1 &&
         std::string_view(text).starts_with("ImageJ=") &&
         std::string_view(text).find("\nimages=") != std::string_view::npos;
}

/// Out of memory: closing must not continue to write.
[[noreturn]] void give_up(TIFF* tiff) {
  TIFFSetMode(tiff, O_RDONLY);
  throw std::bad_alloc();
}

}  // namespace

Picture read_png(std::span<const std::uint8_t> bytes, std::size_t frames) {
  if (auto plain = read_plain_png(bytes, frames)) return *std::move(plain);

  // All other PNG files, and the reason if one is damaged.
  FileInMemory memory{.read = bytes};
  const PngReader reader(memory);
  if (reader.info == nullptr) throw std::bad_alloc();

  std::optional<Picture> picture;
  throw_if(!read_png_rows(reader.png, reader.info, bytes.size(), frames, picture),
           "incomplete PNG file: {}", memory.fault.data());

  return *std::move(picture);
}

std::vector<std::uint8_t> png_file_of(const PictureView& picture) {
  return picture.kind.real() ? std::vector<std::uint8_t>()
                             : png_of_depth(picture, picture.kind.bits);
}

std::vector<std::uint8_t> one_bit_png_file_of(const Image<std::uint8_t>& picture) {
  return png_of_depth(picture, 1);
}

Picture read_tiff(const InputFile& file, const TiffDirectories& directories,
                  std::optional<int> page, std::size_t frames) {
  // 1. The page, which libtiff takes for the first.
  const std::uint64_t directory = directory_of_page(directories, page);
  FileInMemory memory{.input = &file, .header = header_naming(file, directory)};
  const Tiff tiff = open_tiff(memory, "rm");
  require(tiff != nullptr, memory);

  throw_if(!page && directories.offsets.size() == 1 && hides_pages(tiff.get()),
           "an ImageJ stack with one directory for all pages; save each page as a file");

  // 2. Its size and pixels.
  const Size size = size_of(tiff.get(), TIFFTAG_IMAGEWIDTH, TIFFTAG_IMAGELENGTH, frames);
  require(size.width >= 1 && size.height >= 1, memory);
  const PictureKind kind = kind_of(tiff.get(), size);
  const std::uint64_t pixels = std::uint64_t{1} * size.width * size.height;
  require_readable(pixels, frames, kind.bits);
  require_held(kind.row_bytes() * size.height, file.size(), factor_of(tiff.get()));
  Picture picture(kind);

  require(TIFFIsTiled(tiff.get()) != 0 ? read_tiles(tiff.get(), picture, frames)
                                       : read_lines(tiff.get(), picture),
          memory);

  if (photometric_of(tiff.get()) == PHOTOMETRIC_MINISWHITE) invert_levels(picture);
  return picture;
}

std::vector<std::uint8_t> tiff_file_of(const PictureView& picture) {
  FileInMemory memory;
  Tiff tiff = open_tiff(memory, "w");
  if (tiff == nullptr) throw std::bad_alloc();

  // 1. The layout.
  const auto& [size, channels, bits] = picture.kind;
  const auto set = [&](std::uint32_t tag, auto value) { TIFFSetField(tiff.get(), tag, value); };
  set(TIFFTAG_IMAGEWIDTH, size.width);
  set(TIFFTAG_IMAGELENGTH, size.height);
  set(TIFFTAG_BITSPERSAMPLE, bits);
  set(TIFFTAG_SAMPLESPERPIXEL, channels);
  set(TIFFTAG_SAMPLEFORMAT, picture.kind.real() ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT);
  set(TIFFTAG_PHOTOMETRIC, channels == 1 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB);
  set(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);

  // Differences of neighbouring integer samples compress better.
  set(TIFFTAG_COMPRESSION, COMPRESSION_LZW);
  if (!picture.kind.real()) set(TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
  set(TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff.get(), 0));

  if (memory.fault.front() != 0) give_up(tiff.get());

  // 2. The rows.
  for (int row = 0; row < size.height; ++row) {
    // A predictor modifies the row passed to it.
    std::vector<std::uint8_t> line(picture.row(row), picture.row(row) + picture.kind.row_bytes());
    if (TIFFWriteScanline(tiff.get(), line.data(), static_cast<std::uint32_t>(row), 0) < 0) {
      give_up(tiff.get());  // nothing else can fail for a file in memory
    }
  }

  tiff.reset();  // writes the directory
  if (memory.fault.front() != 0) throw std::bad_alloc();

  return std::move(memory.written);
}

}  // namespace slipstream
