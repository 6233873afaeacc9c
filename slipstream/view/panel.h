#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "slipstream/live/live_statistics.h"
#include "slipstream/opengl/picture_texture.h"
#include "slipstream/view/gui.h"
#include "slipstream/view/view_settings.h"
#include "slipstream/view/view_source.h"

namespace slipstream::view {

/// What can be chosen in the panel, and what it says.
struct PanelState {
  ViewSettings view;
  EngineSetup setup;
  std::size_t strategy = 0;  ///< of the source's
  std::size_t gamma = 0;     ///< likewise
  bool paused = false;
  bool shown = true;                                   ///< the panel and the pictures
  std::array<bool, 3> picture_open{true, true, true};  ///< camera, modulation, phase
  std::size_t points = 0, pixels = 0;
  double drawn_per_second = 0;
  float grid_mm = 0;
  std::string message;  ///< of what was asked last: where it was saved, why it failed
};

/// What was asked for in this frame, by mouse or key.
struct PanelRequests {
  bool fit = false;
  bool save = false;
  bool toggle_recording = false;
  bool change_setup = false;  ///< PanelState::setup is another
};

/// Widths, in units of the window, that the panel takes at the left and the pictures at the right.
struct PanelWidths {
  float left = 0;
  float right = 0;
};

/// Little windows have no room for pictures beside the cloud, and none have any for what is hidden.
PanelWidths panel_widths(const PanelState& state, const ViewSource& source, const Screen& screen);

/// The panel at the left: rates, how the cloud is drawn, what is looked for, what can be done.
void draw_panel(PanelState& state, PanelRequests& requests, const ViewSource& source,
                const LiveStatistics& statistics, const Screen& screen);

/// Camera, modulation and phase at the right.
void draw_pictures(PanelState& state, const std::array<opengl::PictureTexture, 3>& pictures,
                   const ViewSource& source, const Screen& screen);

}  // namespace slipstream::view
