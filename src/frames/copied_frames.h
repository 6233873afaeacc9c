#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "slipstream/frame_set.h"

namespace slipstream {

/// A copy of the frames; without the gain of merged ones.
inline FrameSet copied(const FrameViews& frames) {
  return frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    std::vector<Image<Pixel>> images;
    for (const ImageView<const Pixel>& view : views) {
      images.emplace_back(view.size());
      for (int row = 0; row < view.height(); ++row) {
        std::copy_n(view.row(row), view.width(), images.back().row(row));
      }
    }

    return FrameSet(std::move(images), frames.bits());
  });
}

}  // namespace slipstream
