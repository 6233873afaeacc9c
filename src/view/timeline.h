#pragma once

#include <cstddef>

#include "view/panel.h"

namespace slipstream::view {

/// Height of the timeline, in window units: 0 for a source of one scan, or if it is hidden.
float timeline_height(const PanelState& state, const ViewSource& source);

/// Draws a slider over the scans of a recording, and buttons to step and to play, at the lower edge
/// of an area.
void draw_timeline(PanelState& state, PanelRequests& requests, const ViewSource& source,
                   const Area& area);

/// The scan `steps` after another; the first follows the last.
std::size_t scan_after(std::size_t scan, const ViewSource& source, int steps);

}  // namespace slipstream::view
