#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "decode/neighbourhood_vote.h"
#include "reconstruct/fused/vote_rows.h"

namespace slipstream {

/// Input of NeighbourhoodVote, in images of one width that keep the last rows, a power of two of
/// them, with 16 more columns on both sides. Each pointer is to the pixel at row 0, column 0.
struct BallotRows {
  const float* coordinate = nullptr;                      ///< NaN if invalid or outside the image
  const std::int16_t* shift = nullptr;                    ///< null if all are 0
  std::array<const float*, order_shifts.size()> costs{};  ///< OrderCosts of the voters
  std::ptrdiff_t stride = 0;
  int kept_rows = 1;
  float periods = 12;  ///< f_h
};

/// NeighbourhoodVote::chosen_shift of each pixel. It stays `undecided` if orders beyond those of
/// order_shifts would matter, or rounding or a line of pixels could decide. With `restores`: 0 if
/// NeighbourhoodVote::has_support, else 1.
void hold_ballots(const BallotRows& rows, std::span<ShiftedPixel> pixels, bool restores);

}  // namespace slipstream
