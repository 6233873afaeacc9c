#pragma once

#include <optional>

#include "slipstream/geometry/ray_blocks.h"
#include "slipstream/geometry/ray_table.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/reconstruct/fused_rows.h"
#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/strategy/strategy.h"

namespace slipstream {

/// The stages of the fused pass for one scanner, strategy and axis, in the order in which a row
/// meets them.
struct FusedStages {
  /// A second sinusoid says which period of the first it is, and its neighbours confirm that.
  struct LowFrequency {
    SinusoidStage sinusoid;
    UnwrapStage unwrap;
    ConsensusStage consensus;
  };

  SinusoidStage sinusoid;  ///< the only one or that of the high frequency
  std::optional<LowFrequency> low;
  CoordinateStage coordinate;
  PointStage point;
  RayTable rays;
  std::optional<RayBlocks> blocks;  ///< none for small pictures

  [[nodiscard]] int frame_count() const { return sinusoid.steps + (low ? low->sinusoid.steps : 0); }
};

/// None where the fused pass cannot stand in for the double-precision one: for another strategy
/// than phase-shifted sinusoids, a lens too bent for StripeGeometry or RayTable, a picture narrower
/// than `least_row_width` or a field margin above a quarter.
std::optional<FusedStages> fused_stages(const Scanner& scanner, const Strategy& strategy, Axis axis,
                                        const ReconstructSettings& settings);

/// The limits of one sinusoid for frames whose largest grey level is `full_scale`. `mean_of`: what
/// one grey level of the frames counts for in the mean.
SinusoidLimits sinusoid_limits(const SinusoidStage& stage, const ReconstructSettings& settings,
                               double full_scale, double mean_of);

}  // namespace slipstream
