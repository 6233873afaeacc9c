#pragma once

#include "slipstream/live_pipeline.h"
#include "view/panel.h"

namespace slipstream::view {

/// Draws the part of the panel with rates, losses, delays and threads of a live run.
void draw_speed(const PanelState& state, const LiveStatistics& statistics);

}  // namespace slipstream::view
