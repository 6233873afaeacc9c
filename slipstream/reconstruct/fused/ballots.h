#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "slipstream/decode/neighbourhood_vote.h"

// What sinusoid_rows.h says of its functions holds for these.
namespace slipstream {

/// What NeighbourhoodVote looks at, in images of one width that keep the last rows, a power of two
/// of them, and have 16 columns more on both sides. Of each the pixel of row 0, column 0.
struct BallotRows {
  const float* coordinate = nullptr;  ///< NaN where it means nothing and outside the picture
  const std::int16_t* shift = nullptr;
  const float *below = nullptr, *above = nullptr;  ///< OrderCosts of those that vote
  std::ptrdiff_t stride = 0;
  int kept_rows = 1;
  float periods = 12;  ///< f_h
};

/// NeighbourhoodVote::chosen_shift of each pixel, which is set here but where orders beyond the
/// next would have a say, or rounding or a line of pixels might decide: those stay `undecided`.
void hold_ballots(const BallotRows& rows, std::span<ShiftedPixel> pixels);

/// Likewise 0 where NeighbourhoodVote::has_support, else 1.
void find_support(const BallotRows& rows, std::span<ShiftedPixel> pixels);

}  // namespace slipstream
