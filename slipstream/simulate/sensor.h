#pragma once

#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {

/// What the sensor makes of frame n, grey levels of 8 bits: noise as the photometry says, the same
/// for the same seed.
void add_noise(Image<double>& frame, int n, const Photometry& photometry);

/// The frames rounded and clipped to `bits`; as they are where there are none.
FrameSet digitised(std::vector<Image<double>> exposures, std::optional<int> bits);

}  // namespace slipstream
