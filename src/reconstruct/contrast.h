#pragma once

#include "slipstream/engine.h"

// The camera's blur mixes neighbouring pixels. Where reflectivity changes, the brighter ones pull
// the coordinate y towards theirs: to first order by s^2 (grad B / B) . grad y, with the modulation
// B and the variance s^2 of the places that a pixel mixes. The projector's blur does not do that.
namespace slipstream {

/// How far contrast pulls each coordinate.
struct ContrastPull {
  double variance = 0;  ///< s^2, pixels^2; 0: too little pull to tell it from noise
  Image<float> pull{};  ///< to be subtracted from y, fields; 0 where y stays
};

/// Finds s^2 where the surface is smoothest after correction, and the pull of the pixels whose
/// gradient of B is significant. Pixels beside a step, and those whose surroundings would not
/// become smoother, stay as they are. Uses valid pixels only; all images have one size.
ContrastPull contrast_pull(const Image<float>& coordinate, const Image<float>& modulation,
                           const Image<Validity>& validity);

/// Throws Error unless the patterns give phases, which blur pulls; codes alone do not.
void require_contrast_correctable(const EngineSetup& setup);

/// Takes the pull of contrast from the coordinates of the valid points in `maps`, where it is kept,
/// and moves these points along their rays to match; rejects those that leave the field or the
/// depth range.
void correct_contrast(const EngineSetup& setup, Cloud& cloud, Maps& maps);

}  // namespace slipstream
