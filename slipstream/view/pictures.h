#pragma once

#include "slipstream/capture/frame_views.h"
#include "slipstream/image/colour.h"
#include "slipstream/image/image.h"

namespace slipstream::view {

/// The first of the frames as a grey picture, red where any of them is saturated. Large pictures
/// are reduced to about `widest` pixels; of the pixels put together one that is saturated shows.
Image<Colour> camera_picture(const FrameViews& frames, int widest);

/// Modulation B^c, grey levels, black to white from 0 to its 99th percentile.
Image<Colour> modulation_picture(const Image<float>& modulation, int widest);

/// Wrapped phase, [0, 2 pi), once round the hues; dark where the modulation is below `least`.
Image<Colour> phase_picture(const Image<float>& phase, const Image<float>& modulation, float least,
                            int widest);

}  // namespace slipstream::view
