#pragma once

#include <cstddef>
#include <vector>

#include "slipstream/virtual_scanner.h"

namespace slipstream {

/// What a camera makes of the light of frames of one size, the first with number n, grey levels of
/// 8 bits: exposure, noise, processing, rounding to the photometry's bits, compression.
/// `channels`: frames of each picture. Deterministic for a seed.
FrameSet camera_pictures(std::vector<Image<double>> light, int n, const Photometry& photometry,
                         std::size_t channels = 1);

}  // namespace slipstream
