#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "decode/neighbourhood_vote.h"
#include "reconstruct/fused/cue_rows.h"
#include "reconstruct/fused/rows.h"
#include "reconstruct/fused/stage_numbers.h"

namespace slipstream {

/// A row of coordinates and its neighbours. Each has one NaN before it, and after it enough to
/// complete a vector plus one.
struct CoordinateRows {
  int width = 0, row = 0;
  const float *above = nullptr, *here = nullptr, *below = nullptr;
  /// One per vector: whether a step from the row above may disagree; on return, to the row below.
  std::uint8_t* far_above = nullptr;
};

/// Appends, from left to right, the pixels of NeighbourhoodVote::disagrees, and a few more.
void find_disagreeing(const CueStage& cue, const CoordinateRows& rows,
                      std::vector<PixelPlace>& found);

/// Cost of fringe orders from frames with a cue: CueEvidence::cost.
struct OrderCostStage : OrderCostNumbers {
  /// Weight of each frame in C, in S, and in the cue's channel or its cosine and sine.
  std::vector<double> cosines{}, sines{}, cue{}, cue_sine{};
};

/// Shifts of a pixel's fringe order whose costs votes need often.
inline constexpr std::array order_shifts{-2, -1, 1, 2};
constexpr std::size_t index_of_shift(int shift) {
  return static_cast<std::size_t>(shift < 0 ? shift + 2 : shift + 1);
}

/// Costs of the shifted orders, minus the cost of the pixel's own; infinite outside the field.
using OrderCosts = std::array<float*, order_shifts.size()>;

inline constexpr int costed_together = 16;

/// Costs of `costed_together` pixels. `to_8_bits`: 8-bit levels per grey level of the frames;
/// `coordinate`: from the pixels' own orders; costs are undefined where it is NaN.
void order_costs(const OrderCostStage& stage, float to_8_bits, const FrameRows& frames,
                 const float* coordinate, const OrderCosts& costs);

}  // namespace slipstream
