#include "slipstream/live/window_reconstructor.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/live/window_frames.h"

namespace slipstream {
namespace {

Image<float> narrowed(const Image<double>& image) {
  Image<float> narrow(image.size());
  std::transform(image.begin(), image.end(), narrow.begin(),
                 [](double value) { return static_cast<float>(value); });
  return narrow;
}

/// Views of the window's frames, in memory that is kept from one to the next.
template <class Pixel>
const Frames<Pixel>& view(const std::vector<Pooled<Frame>>& window, Frames<Pixel>& views) {
  views.clear();
  for (const Pooled<Frame>& frame : window) {
    views.push_back(std::get<Image<Pixel>>(frame->pixels));
  }
  return views;
}

}  // namespace

WindowReconstructor::WindowReconstructor(const LiveScan& scan, const FrameFormat& format)
    : scan_(scan),
      fused_(FusedReconstructor::make(scan.scanner, scan.strategy, scan.axis, scan.settings)) {
  const Size camera = scan.scanner.camera.size;
  if (camera != format.size) {
    throw Error(fmt::format("frames are {}x{}, the scanner's camera has {}x{}; both must agree",
                            format.size.width, format.size.height, camera.width, camera.height));
  }
  if (!fused_) in_double_.emplace(scan.scanner, scan.strategy, scan.axis, scan.settings);
}

void WindowReconstructor::operator()(const std::vector<Pooled<Frame>>& window, FusedCloud& cloud) {
  if (fused_) {
    const int bits = window.front()->bits;
    if (bits == 8) return (*fused_)(view(window, views8_), cloud);
    return (*fused_)(view(window, views16_), (1 << bits) - 1, cloud);
  }
  Reconstruction scan = (*in_double_)(frame_set_of(window));
  cloud.x = narrowed(scan.cloud.x);
  cloud.y = narrowed(scan.cloud.y);
  cloud.z = narrowed(scan.cloud.z);
  cloud.intensity = std::move(scan.cloud.intensity);
  cloud.validity = std::move(scan.cloud.validity);
}

}  // namespace slipstream
