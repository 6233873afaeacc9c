#pragma once

#include <vector>

#include "slipstream/base/colour.h"
#include "slipstream/calibrate/pose_guide.h"

namespace slipstream {

/// The colour in which a state is told: green where the pose is good or taken, yellow where it only
/// has to be held still, red where something speaks against it.
Colour colour_of(PoseState state);

/// The picture with what guides a person drawn on it: dim and blue where no board was yet, the
/// outlines of the boards that were taken, the corners that are seen in the colour of the state,
/// and at each side an arrow for the edge that was nearer there, green, or that has yet to be,
/// orange. A small picture is enlarged, to `width` pixels at least, so that lines stay thin.
Image<Colour> drawn_guide(const Image<float>& picture, const PoseVerdict& verdict,
                          const PoseNeeds& needs, const std::vector<BoardView>& taken,
                          int width = 1600);

}  // namespace slipstream
