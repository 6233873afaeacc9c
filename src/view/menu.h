#pragma once

#include "view/panel.h"

namespace slipstream::view {

/// Draws the menus at the upper edge of the window, and the list of keys if it is wanted.
void draw_menus(PanelState& state, PanelRequests& requests, const ViewSource& source);

}  // namespace slipstream::view
