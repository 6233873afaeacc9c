#include "slipstream/devices/jpeg.h"

#include "slipstream/base/error.h"

#ifdef SLIPSTREAM_CAMERAS
#include <memory>

#include <turbojpeg.h>
#endif

namespace slipstream {

bool decode_jpeg([[maybe_unused]] std::span<const std::uint8_t> bytes,
                 [[maybe_unused]] Image<std::uint8_t>& grey) {
#ifdef SLIPSTREAM_CAMERAS
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
  Size size;
  int sampling = 0, colours = 0;
  return tjDecompressHeader3(decoder.get(), bytes.data(), bytes.size(), &size.width, &size.height,
                             &sampling, &colours) == 0 &&
         size == grey.size() &&
         tjDecompress2(decoder.get(), bytes.data(), bytes.size(), grey.begin(), size.width, 0,
                       size.height, TJPF_GRAY, 0) == 0;
#else
  throw Error("--pixel-format MJPG: this build has no camera support");
#endif
}

}  // namespace slipstream
