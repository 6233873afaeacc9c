#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "io/file.h"
#include "io/pictures.h"

namespace slipstream {

/// A PNG file of 8 or 16 bits, without alpha. All its checksums must be right.
Picture read_png(std::span<const std::uint8_t> bytes, std::size_t frames);

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

}  // namespace slipstream
