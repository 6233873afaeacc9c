#pragma once

#include <vector>

#include "slipstream/frames/frame_set.h"

namespace slipstream {

/// The memory of merged frames, and their views.
struct MergedFrames {
  FrameSet::Images16 images{};
  Image<float> gain{};
  FrameViews views{};
};

/// Merges frames of relative exposures t_e to those of one, pixel by pixel: I_n = sum t_e I_n,e /
/// sqrt(sum t_e^2) over the exposures e of which no frame of the pixel is saturated. The signal
/// grows as t_e under noise that does not, so that these weights are those of inverse predicted
/// variance; a merged frame has the noise of a single one, and a modulation sqrt(sum t_e^2) times
/// that of exposure 1. All that is linear in the frames is merged so at once, phases before their
/// arctangent: their fringe order is one.
///
/// A pixel that every exposure saturates has the frames of the shortest, and is saturated in them.
/// `frames` come exposure by exposure, at most 16; the merged ones have 14 bits and a gain: see
/// FrameViews. Memory is used where it is of the size. Throws Error where the frames are not as
/// many for each exposure, or are not quantised: what is never saturated needs no second exposure.
void merge_exposures(const FrameViews& frames, const std::vector<double>& exposures,
                     MergedFrames& merged);

/// The same, with memory of their own.
FrameSet merged_exposures(const FrameViews& frames, const std::vector<double>& exposures);

}  // namespace slipstream
