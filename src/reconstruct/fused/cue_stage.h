#pragma once

#include "reconstruct/engine_setup.h"
#include "reconstruct/fused/fused_stages.h"

namespace slipstream {

/// Whether the kernels can find the setup's cue in the frames.
bool has_fused_cue(const EngineSetup& setup);

/// The stage of that cue: how the kernels find it and how the neighbours vote on its orders.
FusedStages::Cue fused_cue(const Layout& layout, const EngineSetup& setup);

}  // namespace slipstream
