#pragma once

#include <cstdint>

#include "slipstream/base/image.h"
#include "slipstream/frames/frame_views.h"
#include "slipstream/response/measured_harmonics.h"

namespace slipstream {

/// Of the `steps` frames that start at `first`, every pixel, in grey levels.
Image<MeasuredHarmonics> pixel_harmonics(const FrameViews& frames, int first, int steps);

/// 1 where a pixel serves to find gamma: modulation of at least `minimum` grey levels and none of
/// the frames saturated. `minimum` 0 or less: a sixteenth of the frames' full scale.
Image<std::uint8_t> well_lit(const Image<MeasuredHarmonics>& pixels, const FrameViews& frames,
                             double minimum = 0);

}  // namespace slipstream
