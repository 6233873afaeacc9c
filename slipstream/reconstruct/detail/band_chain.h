#pragma once

#include <cstdint>
#include <vector>

#include "slipstream/reconstruct/fused/fused_engine.h"

// Rows of the fused pass along the chain by which bands are unwrapped.
namespace slipstream {

/// The turns of a sum of bands; where it is one band its own, else in `to`.
const float* sum_row(const std::vector<int>& of, int width, FusedScratch& scratch, float* to);

/// What the chain begins with where that is no code: turns, or coordinates.
const float* first_of_chain(const FusedStages& stages, int width, FusedScratch& scratch);

/// What bits are compared with.
struct CodeLevels {
  const float* mean = nullptr;  ///< a row of the first band's mean
  float mean_to_frames = 1;     ///< from that to grey levels of the frames
};

/// The middle of each pixel's stripe.
template <class Pixel>
const float* code_coordinates(const FusedStages::CodeBits& code, const Pixel* const* frames,
                              int width, const CodeLevels& levels, FusedScratch& scratch);

/// The coordinates of all bands weighed, at the fringe orders next to `y`, in place.
void weigh_bands(const FusedStages& stages, int width, FusedScratch& scratch, float* y);

}  // namespace slipstream
