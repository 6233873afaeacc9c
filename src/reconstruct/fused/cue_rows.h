#pragma once

#include <cstdint>
#include <vector>

#include "reconstruct/fused/rows.h"
#include "reconstruct/fused/sinusoid_rows.h"

namespace slipstream {

/// From a cue to a coordinate, Liu 2010, Section 3.2: R = 2 y - 1 in the mean for N = 3 (3.53), R =
/// cos(pi y) in the half phase channel for N = 4 (3.68), one period in the second full phase
/// channel for N >= 5 (3.83); the linear cue of other strategies, and all of these in windows
/// longer than a cycle.
struct CueStage : CueNumbers {
  enum class Sums {
    closed,    ///< those of N = 3 to 6, in integers
    mirrored,  ///< by the weights below, the same of frames n and N - n up to a sign
    any,       ///< by any weights
  };

  CueForm form = CueForm::circle;
  Sums sums = Sums::closed;
  /// Weights of the cue's channel, (3.86), (3.85), unless its sums are closed.
  std::vector<double> cosines{}, sines{};
  float channel_scale = 1;       ///< grey levels per unit of the channel's sum
  float sine_weight = 1;         ///< of the second channel's sine sum relative to its cosine sum
  CoordinateStage coordinate{};  ///< of f_h, within one field
};

/// One row of results from frames with a cue. `modulation` may be null; so may the last three if
/// only points are wanted.
struct CueRow {
  SinusoidLimits limits{};
  CueLimits cue_limits{};
  int width = 0;
  /// From each pixel alone; NaN if it does not vote on its neighbours' orders.
  float* coordinate = nullptr;
  float* mean = nullptr;
  std::int32_t* flags = nullptr;  ///< PixelFlag
  bool past_cache = false;        ///< `mean` is aligned to 8 floats and written past the cache
  float* modulation = nullptr;
  float *turn = nullptr, *doubt = nullptr;
  float* unhidden_coordinate = nullptr;  ///< the same, but never NaN
};

/// Frames of a row to coordinates, from the high frequency and its cue together.
void decode_row(const SinusoidStage& stage, const CueStage& cue, const FrameRows& frames,
                const CueRow& row);

}  // namespace slipstream
