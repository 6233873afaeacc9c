#pragma once

#include <optional>
#include <vector>

#include "slipstream/decode/cue_evidence.h"
#include "slipstream/geometry/stripe_geometry.h"
#include "slipstream/reconstruct/fused/rows.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream {

/// The stages of the fused pass for one scanner, layout and axis, in the order in which a row meets
/// them.
struct FusedStages {
  struct BandStage {
    SinusoidStage sinusoid;
    int first_frame = 0;  ///< of those that it takes
    double periods = 1;
    float weight = 0;  ///< of its coordinate, see band_weights
  };

  /// A sum of the bands' turns, unwrapped by what is before it.
  struct Link {
    std::vector<int> of;  ///< a factor for each of `bands`
    UnwrapStage unwrap{};
  };

  /// What the chain begins with where it is no band.
  struct CodeBits {
    CodeStage stage;
    bool against_mean = false;     ///< of the first band
    std::vector<float> reference;  ///< else a weight for each frame, or inverses
  };

  /// A cue in the frames of the first band says which period it is, and the neighbourhood votes.
  struct Cue {
    CueStage stage;
    CueEvidence exact;  ///< for pixels one by one
    double f_h = 12;
    int projector_length = 0;  ///< of the projector along the axis, pixels
    double dimmest_lit = 0;    ///< grey levels of 255: see CueEvidence::lit
    double ambient = 0;        ///< beta, grey levels of 255; 0 where the cue does not need it
    OrderCostStage costs;
  };

  int frames = 0;
  /// The measuring one first; with a cue it alone.
  std::vector<BandStage> bands;
  std::vector<int> coarse;  ///< what the chain begins with, a factor for each band; or empty:
  std::optional<CodeBits> code;
  bool coarse_given = false;       ///< the coordinate itself, see unwraps_by_picture
  bool coarse_in_field = false;    ///< it is brought into the field, for the chain is no circle,
  CoordinateStage coarse_stage{};  ///< by this
  std::vector<Link> chain;         ///< empty: one band of at most one period, or a cue
  bool weighs_bands = false;       ///< the coordinate is that of several bands
  std::optional<Cue> cue;
  ConsensusStage consensus;  ///< where there are several bands or a cue
  /// From turns of a single band to coordinates, or from those of several in fields.
  CoordinateStage coordinate;
  PointStage point;
  RayTable rays;
  /// None for small pictures. With one band they describe only what lies before the cut of
  /// `coordinate`.
  std::optional<RayBlocks> blocks;
};

/// None, with `why_not` unless that is null, where the fused pass cannot stand in for the reference
/// engine: for Unwrapping::likelihood, code_alone and single_frames, a cue of other weights or
/// another reference than those of Eqs. (3.53), (3.68), (3.83), another rule than
/// CueRule::consensus, a lens too bent for StripeGeometry or RayTable, a picture narrower than
/// `least_row_width`, a frequency above 16384 under a cue or a field margin above a quarter.
std::optional<FusedStages> fused_stages(const EngineSetup& setup,
                                        const PhaseCorrections& corrections,
                                        std::string* why_not = nullptr);

/// The limits of one sinusoid for frames of such full scale and saturation: see FrameViews.
/// `mean_of`: what one grey level of the frames counts for in the mean.
SinusoidLimits sinusoid_limits(const SinusoidStage& stage, const ReconstructSettings& settings,
                               double full_scale, double saturation, double mean_of);

/// The limits of a cue likewise.
CueLimits cue_limits(const FusedStages& stages, const ReconstructSettings& settings,
                     double full_scale);

/// Frames to the turns of a band, corrected for the response where that is known.
FusedStages::BandStage band_stage(const Band& band, const PhaseCorrections& corrections);

/// To 8e-7 rad. Empty for other N, where the correction is no odd function of the phase or leads
/// out of [0, T], and where it bends too much.
FoldedPhase folded_phase(const PhaseCorrection& correction);

}  // namespace slipstream
