#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "slipstream/decode/neighbourhood_vote.h"
#include "slipstream/reconstruct/fused/sinusoid_rows.h"

// Kernels of the neighbours' vote. What sinusoid_rows.h says of its functions holds for these.
namespace slipstream {

/// A row of coordinates and its neighbours; all three have a NaN before, and after as many as
/// complete a vector and one more.
struct CoordinateRows {
  int width = 0;
  int row = 0;
  const float* above = nullptr;
  const float* here = nullptr;
  const float* below = nullptr;
  /// Of each pixel, or of fewer vectors: whether a step from the row above may be one that
  /// disagrees; then the same of the step to the row below.
  std::uint8_t* far_above = nullptr;
};

/// Appends, from left to right, the pixels of a row that may disagree with one of the four beside
/// them: all for which NeighbourhoodVote::disagrees says so, and a few more.
void find_disagreeing(const CueStage& cue, const CoordinateRows& rows,
                      std::vector<PixelPlace>& found);

/// How frames with a cue say what a fringe order costs: CueEvidence::cost.
struct OrderCostStage {
  /// What a frame counts for in C, S, and in the cue's channel or its cosine and sine.
  std::vector<double> cosines{}, sines{}, cue{}, cue_sine{};
  enum class Cue { linear, cosine, circle };
  Cue form = Cue::linear;
  float share = 1, cue_share = 1;  ///< c_1, c_2
  float constant_light = 0, steady = 0, component_variance = 1, cue_variance = 1;
  float periods = 12;  ///< f_h
  float margin = 0;    ///< how far past the field a coordinate may lie: CueEvidence::near_field
};

/// What it costs a pixel to be one period below or above its own fringe order, less what that one
/// costs; infinite past the field.
struct OrderCosts {
  float *below = nullptr, *above = nullptr;  ///< of the pixels of a row
};

inline constexpr int costed_together = 16;

/// Of `costed_together` pixels. `to_8_bits`: a grey level of the frames in those of an 8-bit
/// device; `coordinate`: by their own orders; where it is NaN the costs mean nothing.
void order_costs(const OrderCostStage& stage, float to_8_bits, const FrameRows& frames,
                 const float* coordinate, const OrderCosts& costs);

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
