#pragma once

#include "view/gui.h"
#include "view/measuring.h"
#include "view/panel.h"
#include "view/scene_renderer.h"

// The mouse over the cloud.
namespace slipstream::view {

/// Turns, moves and zooms the view by the mouse.
void move_camera(PanelState& state, const Pane& pane, const Screen& screen);

/// Names the point under the mouse and, if the mouse measures, takes points by clicks and drags.
void measure(PanelState& state, const CloudOnPicture& shown, const Area& area, float pixel_ratio);

}  // namespace slipstream::view
