#pragma once

#include "view/gui.h"
#include "view/panel.h"

namespace slipstream::view {

/// Draws the menus at the upper edge of the window, and the list of keys if it is wanted.
void draw_menus(PanelState& state, PanelRequests& requests, const ViewSource& source);

/// Asks whether to close, in the middle of the window, if PanelState::closing is set.
void draw_closing(PanelState& state, PanelRequests& requests, const Screen& screen);

}  // namespace slipstream::view
