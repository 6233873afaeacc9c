#pragma once

#include <cstdint>
#include <vector>

#include "slipstream/decode/neighbourhood_vote.h"
#include "slipstream/reconstruct/fused/sinusoid_rows.h"

// The stages of the fused pass for a cue in the frames of the sinusoid itself. What sinusoid_rows.h
// says of its functions holds for these.
namespace slipstream {

/// How the cue of PCMP becomes a coordinate, Liu 2010, Section 3.2: for N = 3 and 4 a reference in
/// the mean and in the half phase channel, R = 2 y - 1 (3.53) and R = cos(pi y) (3.68), for N >= 5
/// one period in the second full phase channel (3.83).
struct CueStage {
  std::vector<double> cosines{};  ///< of the second channel, (3.86), (3.85); for N above 6
  std::vector<double> sines{};
  float sine_weight = 1;  ///< of the second channel's sine sum against its cosine sum
  /// R = gain (channel - ambient) / B_1 - offset, (3.58), (3.74).
  float gain = 1;
  float offset = 0;
  float shade = 0;     ///< c_2 / c_1: what R adds to the mean, over B_1
  float periods = 12;  ///< f_h
  float largest_doubt = 0.25F;
  CoordinateStage coordinate;  ///< of f_h, known within one field
};

/// What depends on the camera's bits, beside SinusoidLimits.
struct CueLimits {
  float ambient = 0;        ///< beta, grey levels of the frames
  float lit_square = 0;     ///< of U^2 + sine_square V^2: up to it a pixel is `dim`
  float voting_square = 0;  ///< likewise: below it a pixel has no say in its neighbours' orders
};

/// Where a row of such frames goes. `modulation` may be null, and the last three are where only
/// points are wanted.
struct CueRow {
  int width = 0;
  /// As each pixel alone says it; NaN where it has no say in its neighbours' orders.
  float* coordinate = nullptr;
  float* mean = nullptr;
  std::int32_t* flags = nullptr;  ///< PixelFlag
  bool past_cache = false;        ///< `mean` is aligned to 8 floats and written past the cache
  float* modulation = nullptr;
  float* turn = nullptr;
  float* doubt = nullptr;
  float* unhidden_coordinate = nullptr;  ///< as `coordinate`, but a number at every pixel
};

/// Frames of a row to coordinates, by the high frequency and its cue at once.
void decode_row(const SinusoidStage& stage, const CueStage& cue, const SinusoidLimits& limits,
                const CueLimits& cue_limits, const std::uint8_t* const* frames, const CueRow& row);
void decode_row(const SinusoidStage& stage, const CueStage& cue, const SinusoidLimits& limits,
                const CueLimits& cue_limits, const std::uint16_t* const* frames, const CueRow& row);

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

}  // namespace slipstream
