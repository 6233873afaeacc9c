#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/frames/frame_source.h"
#include "slipstream/live/live_statistics.h"
#include "slipstream/view/gui.h"
#include "slipstream/view/measuring.h"
#include "slipstream/view/opengl.h"
#include "slipstream/view/pictures.h"
#include "slipstream/view/scene_renderer.h"
#include "slipstream/view/view_source.h"

namespace slipstream::view {

/// A setting of the camera, as it was last asked for.
struct ShownControl {
  CameraControl which;
  ControlValue value;
};

/// What can be chosen in the panel, and what it says.
struct PanelState {
  ViewSettings view;
  EngineSetup setup;
  std::size_t strategy = 0;  ///< of the source's
  std::size_t gamma = 0;     ///< likewise
  std::vector<ShownControl> camera;
  bool paused = false;
  bool shown = true;                                   ///< the panel and the pictures
  std::array<bool, 3> picture_open{true, true, true};  ///< camera, modulation, phase
  std::size_t picture = 0;  ///< of those, the one that is shown large where there are no points
  std::array<std::size_t, validity_count> counts{};  ///< pixels by Validity
  std::size_t pixels = 0;
  GreyHistogram histogram{};
  double modulation = 0;  ///< median, grey levels of 255; where there are no points
  bool measures = false;  ///< the mouse measures; it turns the cloud where false
  Measured measured;
  std::array<char, 1024> path{};      ///< of the file to open
  std::vector<std::string> openable;  ///< what lies beside the one shown
  double drawn_per_second = 0;
  float grid_mm = 0;
  std::string message;  ///< of what was asked last: where it was saved, why it failed
};

/// What was asked for in this frame, by mouse or key.
struct PanelRequests {
  bool fit = false;
  std::optional<Viewpoint> viewpoint{};
  bool save = false;
  bool toggle_recording = false;
  bool change_setup = false;                  ///< PanelState::setup is another
  std::optional<ShownControl> set_control{};  ///< of the camera
  std::string open{};                         ///< path; nothing where empty
};

/// Whether the source has pictures alone: frames without a scanner to make points of them.
bool pictures_alone(const ViewSource& source);

/// Widths, in units of the window, that the panel takes at the left and the pictures at the right.
struct PanelWidths {
  float left = 0;
  float right = 0;
};

/// Little windows have no room for pictures beside the cloud, and none have any for what is hidden.
PanelWidths panel_widths(const PanelState& state, const ViewSource& source, const Screen& screen);

/// The panel at the left: what is amiss, how the cloud is drawn, what is looked for, what can be
/// done, rates.
void draw_panel(PanelState& state, PanelRequests& requests, const ViewSource& source,
                const LiveStatistics& statistics, const Screen& screen);

/// Camera with its histogram, modulation and phase at the right.
void draw_pictures(PanelState& state, const std::array<opengl::PictureTexture, 3>& pictures,
                   const ViewSource& source, const Screen& screen);

/// Why a cloud has next to no points, for people; empty where it has some.
std::string why_no_points(const PanelState& state);

}  // namespace slipstream::view
