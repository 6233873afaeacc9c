#pragma once

#include "slipstream/live/live_pipeline.h"
#include "slipstream/view/view_source.h"

namespace slipstream::view {

/// The clouds of a pipeline that runs, made by `setup` at first; it must live longer than what is
/// returned. Other responses can be chosen and, where the patterns can change, other strategies;
/// files are left to whoever knows of them.
ViewSource live_source(LivePipeline& pipeline, const EngineSetup& setup, bool patterns_can_change);

}  // namespace slipstream::view
