#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "io/file.h"
#include "slipstream/image.h"

// Picture formats, from and to the bytes of a file. Readers throw Error without a file name, and
// before allocating memory for more pixels than allowed for one of `frames` pictures. Writers
// return no bytes for samples that their format does not support.
namespace slipstream {

class InputFile;

struct PictureKind {
  Size size;         ///< in pixels
  int channels = 1;  ///< grey, RGB or RGBA
  int bits = 8;      ///< of a sample: 8 or 16, or float of 32 or 64

  [[nodiscard]] bool real() const { return bits > 16; }

  [[nodiscard]] std::size_t row_bytes() const {
    return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(channels * bits / 8);
  }
};

/// Rows of samples.
struct Picture {
  /// Leaves the samples uninitialised.
  explicit Picture(const PictureKind& of);

  [[nodiscard]] std::uint8_t* row(int row);

  PictureKind kind;
  int used_bits = kind.bits;  ///< of the highest level that the file declares
  bool lossy = false;         ///< compressed as JPEG
  std::variant<Image<std::uint8_t>, Image<std::uint16_t>, Image<float>, Image<double>> samples;
};

/// A non-owning view of a Picture.
struct PictureView {
  template <class Sample>
  explicit PictureView(ImageView<const Sample> samples, int channels = 1)
      : kind{{samples.width() / channels, samples.height()}, channels, 8 * int{sizeof(Sample)}},
        first(reinterpret_cast<const std::uint8_t*>(samples.row(0))),
        stride(samples.stride() * std::ptrdiff_t{sizeof(Sample)}) {}

  template <class Sample>
  PictureView(const Image<Sample>& grey)  // NOLINT(google-explicit-constructor)
      : PictureView(ImageView<const Sample>(grey)) {}

  [[nodiscard]] const std::uint8_t* row(int row) const { return first + row * stride; }

  PictureKind kind;
  const std::uint8_t* first;
  std::ptrdiff_t stride;  ///< bytes
};

/// Throws Error if `pixels` exceeds the limit of one picture, or of `frames` frames.
void require_readable(std::uint64_t pixels, std::size_t frames);

/// A PNG file of 8 or 16 bits, without alpha. All its checksums must be right.
Picture read_png(std::span<const std::uint8_t> bytes, std::size_t frames);

/// The same for grey and RGB without interlacing, faster; nullopt for others and damaged files.
std::optional<Picture> read_plain_png(std::span<const std::uint8_t> bytes, std::size_t frames);

std::vector<std::uint8_t> png_file_of(const PictureView& picture);

/// A PNG file with one bit per pixel: 0 is dark, any other level bright.
std::vector<std::uint8_t> one_bit_png_file_of(const Image<std::uint8_t>& picture);

/// The directories of a TIFF file's pictures, from 0, without reduced copies and masks. Throws
/// Error if they cannot all be found, as in ImageJ's files of one directory for many pictures.
std::vector<int> tiff_pages(const InputFile& file);

/// The picture in a directory of a TIFF file: grey of 8 or 16 bits or 32- or 64-bit float, or
/// colour of 8 or 16 bits. nullopt: the only picture; throws Error if there are several.
Picture read_tiff(const InputFile& file, std::optional<int> page, std::size_t frames);

/// A lossless TIFF file.
std::vector<std::uint8_t> tiff_file_of(const PictureView& picture);

/// An uncompressed BMP file of 8 bits: grey if its palette is, otherwise colour.
Picture read_bmp(std::span<const std::uint8_t> bytes, std::size_t frames);
std::vector<std::uint8_t> bmp_file_of(const PictureView& picture);

/// The luminance of a JPEG file.
Picture read_jpeg(std::span<const std::uint8_t> bytes, std::size_t frames);

/// A PGM or PPM file, ASCII or binary: 8 bits, or 16 if its highest level is above 255; levels are
/// not rescaled.
Picture read_pgm(std::span<const std::uint8_t> bytes, std::size_t frames);

/// A binary PGM file of grey samples, 8 or 16 bits.
std::vector<std::uint8_t> pgm_file_of(const PictureView& picture);

/// A NumPy file by numpy.save: rows x columns of 32- or 64-bit float.
Picture read_npy(std::span<const std::uint8_t> bytes);
std::vector<std::uint8_t> npy_file_of(const PictureView& picture);

}  // namespace slipstream
