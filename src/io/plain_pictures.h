#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/pictures.h"

namespace slipstream {

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

/// Decodes the luminance of a JPEG into `grey`. Returns false if the JPEG is damaged or of another
/// size.
bool decode_jpeg(std::span<const std::uint8_t> bytes, Image<std::uint8_t>& grey);

/// Compresses rows of grey or RGB samples as a JPEG of that quality, 1 to 100, and reads them back.
/// Colours are stored at half of the resolution (4:2:0). Throws Error above 65500 columns or rows.
void recompress_jpeg(Image<std::uint8_t>& samples, int channels, int quality);

}  // namespace slipstream
