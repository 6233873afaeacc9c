#pragma once

#include <array>
#include <vector>

#include "reconstruct/fused/rows.h"
#include "reconstruct/fused/unwrap_rows.h"
#include "slipstream/image.h"

namespace slipstream {

/// Tries every fringe order of the measuring band.
struct OrderStage {
  /// A band or frame: cos(2 pi (ratio p - shift)), p the periods of the measuring band.
  struct Wave {
    float ratio = 1;
    float shift = 0;   ///< of a frame, turns
    int frame = 0;     ///< in the scan
    float weight = 0;  ///< of a band: inverse variance of its phase for B = 1
  };
  static constexpr int most_waves = 66;  ///< 3 steps and 63 single frames, as of micro

  float period = 1;          ///< of the band, fields
  float begin = 0, end = 1;  ///< of the field, periods of the band
  int orders = 1;            ///< to try, from -1 on
  float largest_doubt = 0.25F;
  std::vector<Wave> waves{};
  std::size_t steps = 0;  ///< frames of the measuring band, which are first; 0 of bands
  /// Cosine and sine of each frame at the beginning of each order, order after order.
  std::vector<std::array<float, 2>> beginnings{};
};

/// Coordinates from a row of each band, the measuring one first: see Unwrapping::likelihood.
void likelihood_row(const OrderStage& stage, const Image<float>& turns,
                    const Image<float>& modulations, const UnwrappedRow& row);

/// Coordinates from all frames: see Unwrapping::single_frames. Also flags saturated pixels.
void fit_row(const OrderStage& stage, const SinusoidLimits& limits, const FrameRows& frames,
             const float* turn, const UnwrappedRow& row);

}  // namespace slipstream
