#pragma once

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "slipstream/base/image.h"

// The formats of pictures, from and to the bytes of a file. Readers throw Error, which does not
// name the file, before they take memory for more pixels than are read of one of `frames` pictures;
// writers give no bytes for samples that their format does not hold.
namespace slipstream {

struct PictureKind {
  Size size;         ///< in pixels
  int channels = 1;  ///< grey, or red, green and blue, or these and alpha
  int bits = 8;      ///< of a sample: 8 or 16, or of float 32 or 64

  [[nodiscard]] bool real() const { return bits > 16; }
  [[nodiscard]] std::size_t row_bytes() const {
    return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(channels * bits / 8);
  }
};

/// Rows of samples.
struct Picture {
  /// The samples are not written yet.
  explicit Picture(const PictureKind& of);
  [[nodiscard]] std::uint8_t* row(int row);

  PictureKind kind;
  std::variant<Image<std::uint8_t>, Image<std::uint16_t>, Image<float>, Image<double>> samples;
};

/// The same, borrowed.
struct PictureView {
  template <class Sample>
  explicit PictureView(ImageView<const Sample> samples, int channels = 1)
      : kind{{samples.width() / channels, samples.height()}, channels, 8 * int{sizeof(Sample)}},
        first(reinterpret_cast<const std::uint8_t*>(samples.row(0))),
        stride(samples.stride() * std::ptrdiff_t{sizeof(Sample)}) {}
  [[nodiscard]] const std::uint8_t* row(int row) const { return first + row * stride; }

  PictureKind kind;
  const std::uint8_t* first;
  std::ptrdiff_t stride;  ///< bytes
};

/// Throws Error where that many pixels are more than are read, of one picture or in as many frames.
void require_readable(std::uint64_t pixels, std::size_t frames);

/// A PNG file, of 8 or 16 bits, without alpha. Each of its check sums must fit.
Picture read_png(std::span<const std::uint8_t> bytes, std::size_t frames);
std::vector<std::uint8_t> png_file_of(const PictureView& picture);
/// The file, of one bit a pixel, of grey levels: 0 is dark, any other level bright.
std::vector<std::uint8_t> one_bit_png_file_of(const Image<std::uint8_t>& picture);

/// The first picture of a TIFF file: grey of 8 or 16 bits or of 32- or 64-bit float, or colours of
/// 8 or 16 bits.
Picture read_tiff(std::span<const std::uint8_t> bytes, std::size_t frames);
/// Without loss.
std::vector<std::uint8_t> tiff_file_of(const PictureView& picture);

/// A BMP file of 8 bits without compression: grey where its palette is, else in colour.
Picture read_bmp(std::span<const std::uint8_t> bytes, std::size_t frames);
std::vector<std::uint8_t> bmp_file_of(const PictureView& picture);

/// A PGM or PPM file, in letters or binary: of 8 bits, or 16 where it says more than 255 levels, as
/// they stand there.
Picture read_pgm(std::span<const std::uint8_t> bytes, std::size_t frames);
/// The binary file of grey samples of 8 or 16 bits.
std::vector<std::uint8_t> pgm_file_of(const PictureView& picture);

/// A NumPy file, rows x columns of 32- or 64-bit float as numpy.save writes them.
Picture read_npy(std::span<const std::uint8_t> bytes);
std::vector<std::uint8_t> npy_file_of(const PictureView& picture);

}  // namespace slipstream
