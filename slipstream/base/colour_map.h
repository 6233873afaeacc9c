#pragma once

#include <array>

#include "slipstream/base/colour.h"

namespace slipstream {

using ColourMap = std::array<Colour, 256>;

/// The colours of depth, in the viewer as in pictures that are written: red over yellow and green
/// to violet, so that what is near stands out. Of even steps in hue, with yellow and cyan no
/// brighter than they must be.
ColourMap depth_colours();

/// Once round the hues, so that 2 pi looks as 0 does.
ColourMap phase_colours();

}  // namespace slipstream
