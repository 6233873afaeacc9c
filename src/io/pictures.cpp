#include "io/pictures.h"

#include <algorithm>
#include <cstdint>
#include <variant>

#include "base/throw_if-inl.h"
#include "io/file.h"

namespace slipstream {

Picture::Picture(const PictureKind& of) : kind(of) {
  const Size size{of.size.width * of.channels, of.size.height};
  if (of.bits == 8) samples.emplace<Image<std::uint8_t>>(size, uninitialised);
  if (of.bits == 16) samples.emplace<Image<std::uint16_t>>(size, uninitialised);
  if (of.bits == 32) samples.emplace<Image<float>>(size, uninitialised);
  if (of.bits == 64) samples.emplace<Image<double>>(size, uninitialised);
}

std::uint8_t* Picture::row(int row) {
  return std::visit([row](auto& image) { return reinterpret_cast<std::uint8_t*>(image.row(row)); },
                    samples);
}

void require_readable(std::uint64_t pixels, std::size_t frames, int bits) {
  throw_if(pixels > largest_picture, "declares {} pixels; limit {}", pixels, largest_picture);
  // Frames of 32-bit real numbers are kept in 64 bits.
  const std::uint64_t bytes = pixels * static_cast<std::uint64_t>(bits == 32 ? 8 : bits / 8);
  require_scan_fits(frames, std::max<std::uint64_t>(bytes, 1));
}

void require_held(std::uint64_t pixel_bytes, std::uint64_t file_bytes, std::uint64_t factor) {
  throw_if(pixel_bytes / factor > file_bytes,
           "incomplete file: its {} bytes are too few for {} bytes of pixels", file_bytes,
           pixel_bytes);
}

}  // namespace slipstream
