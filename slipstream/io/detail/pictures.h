#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "slipstream/base/image.h"

// The formats of pictures, from and to the bytes of a file. Readers throw Error, which does not
// name the file; writers give no bytes for samples that their format does not hold.
namespace slipstream {

/// Rows of samples, `channels` to a pixel: grey, or red, green and blue, or these and alpha.
struct Picture {
  std::variant<Image<std::uint8_t>, Image<std::uint16_t>, Image<float>, Image<double>> samples{};
  int channels = 1;
};

/// The same, borrowed.
struct PictureView {
  std::variant<ImageView<const std::uint8_t>, ImageView<const std::uint16_t>,
               ImageView<const float>, ImageView<const double>>
      samples{};
  int channels = 1;

  [[nodiscard]] Size size() const {  ///< in pixels
    const Size size = std::visit([](const auto& rows) { return rows.size(); }, samples);
    return {size.width / channels, size.height};
  }
};

/// Numbers in a file's header by their offsets; 0 behind the file's end.
struct HeaderNumbers {
  std::span<const std::uint8_t> bytes;
  bool little_endian;

  [[nodiscard]] std::uint64_t operator()(std::uint64_t at, std::uint64_t size) const {
    if (at > bytes.size() || bytes.size() - at < size) return 0;
    std::uint64_t value = 0;
    for (std::uint64_t i = 0; i < size; ++i) {
      value = value << 8 | bytes[at + (little_endian ? size - 1 - i : i)];
    }
    return value;
  }
};

// What a file's header says of its pixels, looked at before memory is taken; of a TIFF file those
// of one tile where they are more.
std::uint64_t png_pixels(std::span<const std::uint8_t> bytes);
std::uint64_t tiff_pixels(std::span<const std::uint8_t> bytes);
std::uint64_t bmp_pixels(std::span<const std::uint8_t> bytes);
std::uint64_t pgm_pixels(std::span<const std::uint8_t> bytes);

/// A PNG file, of 8 or 16 bits, without alpha. Each of its check sums must fit.
Picture read_png(std::span<const std::uint8_t> bytes);
std::vector<std::uint8_t> png_file_of(const PictureView& picture);
/// The file, of one bit a pixel, of grey levels: 0 is dark, any other level bright.
std::vector<std::uint8_t> one_bit_png_file_of(const Image<std::uint8_t>& picture);

/// The first picture of a TIFF file: grey of 8 or 16 bits or of 32- or 64-bit float, or colours of
/// 8 or 16 bits.
Picture read_tiff(std::span<const std::uint8_t> bytes);
/// Without loss.
std::vector<std::uint8_t> tiff_file_of(const PictureView& picture);

/// A BMP file of 8 bits without compression: grey where its palette is, else in colour.
Picture read_bmp(std::span<const std::uint8_t> bytes);
std::vector<std::uint8_t> bmp_file_of(const PictureView& picture);

/// A PGM or PPM file, in letters or binary: of 8 bits, or 16 where it says more than 255 levels, as
/// they stand there.
Picture read_pgm(std::span<const std::uint8_t> bytes);
/// The binary file of grey samples of 8 or 16 bits.
std::vector<std::uint8_t> pgm_file_of(const PictureView& picture);

/// A NumPy file, rows x columns of 32- or 64-bit float as numpy.save writes them.
Picture read_npy(std::span<const std::uint8_t> bytes);
std::vector<std::uint8_t> npy_file_of(const PictureView& picture);

}  // namespace slipstream
