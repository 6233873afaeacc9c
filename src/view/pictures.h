#pragma once

#include <array>

#include "slipstream/cloud.h"
#include "slipstream/frame_set.h"
#include "slipstream/image.h"

namespace slipstream::view {

/// The first frame in grey, red where any frame is saturated and blue where `validity` is too dark.
/// Large pictures are reduced to about `widest` pixels; single saturated pixels stay visible.
Image<Colour> camera_picture(const FrameViews& frames, int widest,
                             const Image<Validity>* validity = nullptr);

/// Histogram of the frames' grey levels, darkest first: square roots of the counts, the largest 1.
using GreyHistogram = std::array<float, 64>;
GreyHistogram grey_histogram(const FrameViews& frames);

/// Modulation B^c, black at 0 and white at its 99th percentile.
Image<Colour> modulation_picture(const Image<float>& modulation, int widest);

/// Wrapped phase, [0, 2 pi), as hue; dark where the modulation is below `least`.
Image<Colour> phase_picture(const Image<float>& phase, const Image<float>& modulation, float least,
                            int widest);

}  // namespace slipstream::view
