#pragma once

#include "slipstream/codes/layout.h"
#include "slipstream/decode/phase_correction.h"
#include "slipstream/reconstruct/fused/fused_stages.h"

namespace slipstream {

/// Frames to the turns of a band, corrected for the response where that is known.
FusedStages::BandStage band_stage(const Band& band, const PhaseCorrections& corrections);

}  // namespace slipstream
