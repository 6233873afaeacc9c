#pragma once

#include "slipstream/base/image.h"

namespace slipstream {

/// The picture, grey levels of 8 bits, in pixels that are dark (0) or bright (255) and whose mean
/// about any place is its own, by error diffusion. Least amiss once blurred where the picture
/// changes along its rows.
Image<double> one_bit(Image<double> picture);

}  // namespace slipstream
