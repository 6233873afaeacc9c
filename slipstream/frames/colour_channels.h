#pragma once

#include <string>

#include "slipstream/base/colour_mixture.h"
#include "slipstream/frames/frame_set.h"

namespace slipstream {

// A picture in colour is three frames that were taken at once: its red, its green and its blue
// channel, in that order. A projector in colour shows three patterns at once likewise.

inline constexpr int colour_channels = 3;  ///< frames to a picture in colour

/// Of a white surface under no light of the projector, under its red, green and blue alone: frames
/// of three channels each, one after another. By the means of the pixels that some colour lights
/// with a tenth of the brightest or more. Throws Error for other than twelve frames, for saturated
/// ones, for channels that one light does not reach, and for lights that cannot be told apart.
ColourMixture measured_mixture(const FrameViews& pictures);

/// Throws Error unless all are finite and the projector's colours can be told apart.
void require_valid(const ColourMixture& mixture);

/// Frames of 16 bits of each projector colour alone; as many as there were, three for each picture.
/// They are right of a surface that reflects all colours alike; of others where `white`, the
/// channels of a picture of it under an even grey of the projector, says what it does to each.
/// Where a channel of a picture, or of the white one, is saturated all three frames are; where the
/// white one is dark they are dark. Throws Error for a number of frames that is no multiple of
/// three, and for a white picture of other frames.
FrameSet unmixed(const FrameViews& frames, const ColourMixture& mixture,
                 const FrameViews& white = {});

/// What people should know of pictures that are taken apart so; empty where all is well.
std::string doubt_about_colours(bool mixture_known, bool white_known);

}  // namespace slipstream
