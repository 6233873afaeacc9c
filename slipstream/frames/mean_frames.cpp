#include "slipstream/frames/mean_frames.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {

void MeanFrames::add(const FrameSet& frames) {
  const Image<std::uint8_t> saturated = saturation_mask(frames);
  if (count_ == 0) {
    bits_ = frames.bits();
    sums_.assign(static_cast<std::size_t>(frames.count()), Image<double>(frames.size()));
    saturated_ = saturated;
  }
  if (frames.count() != static_cast<int>(sums_.size()) || frames.bits() != bits_ ||
      frames.size() != saturated_.size()) {
    throw Error(fmt::format(
        "scan {} has {} frames of {}x{} with {} bits, the first {} of {}x{} with {}; scans that "
        "are averaged are alike",
        count_, frames.count(), frames.size().width, frames.size().height, frames.bits(),
        sums_.size(), saturated_.width(), saturated_.height(), bits_));
  }
  const double grey_level = frames.full_scale() / 255;
  frames.visit([&](const auto& views) {
    for (std::size_t n = 0; n < views.size(); ++n) {
      for (int row = 0; row < views[n].height(); ++row) {
        for (int column = 0; column < views[n].width(); ++column) {
          sums_[n](column, row) += static_cast<double>(views[n](column, row)) / grey_level;
        }
      }
    }
  });
  std::transform(saturated.begin(), saturated.end(), saturated_.begin(), saturated_.begin(),
                 [](std::uint8_t a, std::uint8_t b) { return a | b; });
  ++count_;
}

FrameSet MeanFrames::mean() const {
  FrameSet::ImagesUnquantised means = sums_;
  for (Image<double>& image : means) {
    for (double& intensity : image) intensity /= count_;
  }
  return FrameSet(std::move(means));
}

}  // namespace slipstream
