#pragma once

#include <cstdint>

#include "slipstream/base/image.h"
#include "slipstream/codes/pattern_set.h"
#include "slipstream/simulate/seen_scene.h"
#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {

/// The light that answers a pattern's intensity: grey levels both, Eq. (4.2).
double responded(double intensity, const Photometry& photometry);

/// The light of a picture that fills the projector's field: even over each pixel, blurred.
ProjectedLight light_of_picture(const Image<std::uint8_t>& picture, const Photometry& photometry);

/// The light of pattern n from a projector of that size, for the samples of `seen`: exact, or where
/// physics say so by pixels of 256 levels, blurred; of binary patterns, and of those with a carrier
/// where anything is blurred, that of their pictures.
ProjectedLight projected_light(const PatternSet& patterns, int n, Size projector,
                               const Photometry& photometry, const SeenScene& seen);

}  // namespace slipstream
