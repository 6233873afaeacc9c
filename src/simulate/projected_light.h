#pragma once

#include <cstdint>

#include "simulate/seen_scene.h"

namespace slipstream {

/// The projector's light for a pattern intensity, both grey levels, Eq. (4.2).
double responded(double intensity, const Photometry& photometry);

/// The light of a picture that fills the projector's field: constant over each pixel, blurred.
ProjectedLight light_of_picture(const Image<std::uint8_t>& picture, const Photometry& photometry);

/// The light of pattern n for the samples of `seen`: exact, or blurred pixels of 256 levels if
/// Physics says so. Uses the pattern's picture for binary patterns, and for carriers with blur.
ProjectedLight projected_light(const PatternSet& patterns, int n, Size projector,
                               const Photometry& photometry, const SeenScene& seen);

}  // namespace slipstream
