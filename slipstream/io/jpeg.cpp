#include "slipstream/io/jpeg.h"

#include <memory>

#include <turbojpeg.h>

#include "slipstream/base/throw_if-inl.h"
#include "slipstream/io/detail/pictures.h"

namespace slipstream {
namespace {

using Decoder = std::unique_ptr<void, int (*)(tjhandle)>;

/// 0 x 0 if the header is damaged.
Size size_in(std::span<const std::uint8_t> bytes, const Decoder& decoder) {
  Size size;
  int sampling = 0, colours = 0;
  const int failed = tjDecompressHeader3(decoder.get(), bytes.data(), bytes.size(), &size.width,
                                         &size.height, &sampling, &colours);
  return failed == 0 ? size : Size{};
}

}  // namespace

bool decode_jpeg(std::span<const std::uint8_t> bytes, Image<std::uint8_t>& grey) {
  const Decoder decoder(tjInitDecompress(), tjDestroy);
  const auto [width, height] = grey.size();
  return size_in(bytes, decoder) == grey.size() &&
         tjDecompress2(decoder.get(), bytes.data(), bytes.size(), grey.begin(), width, 0, height,
                       TJPF_GRAY, TJFLAG_LIMITSCANS) == 0;
}

Picture read_jpeg(std::span<const std::uint8_t> bytes, std::size_t frames) {
  const Size size = size_in(bytes, Decoder(tjInitDecompress(), tjDestroy));
  require_readable(static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height),
                   frames);
  Picture picture({size});
  picture.lossy = true;
  throw_if(size == Size{} || !decode_jpeg(bytes, std::get<Image<std::uint8_t>>(picture.samples)),
           "not a complete JPEG file of 8 bits");
  return picture;
}

}  // namespace slipstream
