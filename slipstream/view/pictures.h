#pragma once

#include <array>

#include "slipstream/base/colour.h"
#include "slipstream/base/image.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/frames/frame_set.h"

namespace slipstream::view {

/// The first of the frames as a grey picture, red where any of them is saturated, and where
/// `validity` says so blue where the pixel is too dark. Large pictures are reduced to about
/// `widest` pixels; of the pixels put together one that is saturated shows.
Image<Colour> camera_picture(const FrameViews& frames, int widest,
                             const Image<Validity>* validity = nullptr);

/// How often the grey levels of the frames come, from the darkest to the brightest: roots of the
/// counts, the largest 1.
using GreyHistogram = std::array<float, 64>;
GreyHistogram grey_histogram(const FrameViews& frames);

/// Modulation B^c, grey levels, black to white from 0 to its 99th percentile.
Image<Colour> modulation_picture(const Image<float>& modulation, int widest);

/// Wrapped phase, [0, 2 pi), once round the hues; dark where the modulation is below `least`.
Image<Colour> phase_picture(const Image<float>& phase, const Image<float>& modulation, float least,
                            int widest);

}  // namespace slipstream::view
