#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "io/file.h"
#include "io/pictures.h"
#include "io/tiff_directories.h"

namespace slipstream {

/// A PNG file of 8 or 16 bits, without alpha. All its checksums must be right.
Picture read_png(std::span<const std::uint8_t> bytes, std::size_t frames);

std::vector<std::uint8_t> png_file_of(const PictureView& picture);

/// A PNG file with one bit per pixel: 0 is dark, any other level bright.
std::vector<std::uint8_t> one_bit_png_file_of(const Image<std::uint8_t>& picture);

/// The picture of a page, counted from 0: grey of 8 or 16 bits or 32- or 64-bit float, or colour of
/// 8 or 16 bits. nullopt: the only picture; throws Error if there are several.
Picture read_tiff(const InputFile& file, const TiffDirectories& directories,
                  std::optional<int> page, std::size_t frames);

/// A lossless TIFF file.
std::vector<std::uint8_t> tiff_file_of(const PictureView& picture);

}  // namespace slipstream
