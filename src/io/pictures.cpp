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

void require_readable(std::uint64_t pixels, std::size_t frames) {
  throw_if(pixels > largest_picture, "declares {} pixels; limit {}", pixels, largest_picture);
  require_scan_fits(frames, std::max<std::uint64_t>(pixels, 1));
}

}  // namespace slipstream
