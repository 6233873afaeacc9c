#pragma once

#include "reconstruct/fused/fused_stages.h"
#include "reconstruct/fused/sinusoid_rows.h"

namespace slipstream {

/// Frames to turns of a band, corrected for the response if known.
FusedStages::BandStage band_stage(const Band& band, const PhaseCorrections& corrections);

/// Accurate to 8e-7 rad. Empty for N other than 3, 4 and 6, if the correction is not an odd
/// function of the phase or leaves [0, T], and if it bends too much.
FoldedPhase folded_phase(const PhaseCorrection& correction);

}  // namespace slipstream
