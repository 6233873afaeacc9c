#pragma once

#include <optional>

#include "slipstream/geometry/ray_blocks.h"
#include "slipstream/geometry/ray_table.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/reconstruct/multiplexed_rows.h"
#include "slipstream/reconstruct/point_rows.h"
#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/reconstruct/sinusoid_rows.h"
#include "slipstream/strategy/multiplexed_cue.h"
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

  /// A cue in the frames of the sinusoid says which period it is, and the neighbourhood votes.
  struct Cue {
    CueStage stage;
    ConsensusStage consensus;
    MultiplexedCue exact;  ///< for pixels one by one
    double f_h = 12;
    int length = 0;          ///< of the projector along the axis, pixels
    double dimmest_lit = 0;  ///< grey levels of 255: see MultiplexedCue::lit
    double ambient = 0;      ///< beta, grey levels of 255; 0 where the cue does not need it
    /// What a frame counts for in C, S, and in the cue's channel or its cosine and sine.
    std::vector<double> cosines, sines, cue, cue_sine;
  };

  SinusoidStage sinusoid;  ///< the only one or that of the high frequency
  std::optional<LowFrequency> low;
  std::optional<Cue> cue;
  CoordinateStage coordinate;
  PointStage point;
  RayTable rays;
  /// None for small pictures. With one frequency they describe only what lies before the cut of
  /// `coordinate`.
  std::optional<RayBlocks> blocks;

  [[nodiscard]] int frame_count() const { return sinusoid.steps + (low ? low->sinusoid.steps : 0); }
};

/// None where the fused pass cannot stand in for the double-precision one: for another strategy
/// than phase-shifted sinusoids and PCMP with its own references, another rule of unwrapping than
/// `consensus`, a lens too bent for StripeGeometry or RayTable, a picture narrower than
/// `least_row_width`, a frequency above 16384 or a field margin above a quarter.
std::optional<FusedStages> fused_stages(const Scanner& scanner, const Strategy& strategy, Axis axis,
                                        const ReconstructSettings& settings);

/// The limits of one sinusoid for frames whose largest grey level is `full_scale`. `mean_of`: what
/// one grey level of the frames counts for in the mean.
SinusoidLimits sinusoid_limits(const SinusoidStage& stage, const ReconstructSettings& settings,
                               double full_scale, double mean_of);

/// The limits of a cue likewise.
CueLimits cue_limits(const FusedStages& stages, const ReconstructSettings& settings,
                     double full_scale);

}  // namespace slipstream
