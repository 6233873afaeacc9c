#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/viewer.h"
#include "view/file_dialog.h"
#include "view/gui.h"
#include "view/measuring.h"
#include "view/opengl.h"
#include "view/pictures.h"

namespace slipstream::view {

/// A camera setting as last requested.
struct ShownControl {
  CameraControl which;
  ControlValue value;
};

/// Choices and texts of the panel.
struct PanelState {
  ViewSettings view;
  EngineSetup setup;
  std::size_t strategy = 0, gamma = 0;  ///< the source's
  std::vector<ShownControl> camera;
  bool paused = false;
  std::size_t scan = 0;                                ///< of the source's scans
  bool plays = false;                                  ///< shows its scans one after another
  std::vector<Finding> findings;                       ///< about the frames shown
  bool shown = true;                                   ///< whether panel and pictures are visible
  std::array<bool, 3> picture_open{true, true, true};  ///< camera, modulation, phase
  std::size_t picture = 0;                             ///< shown large, without points
  std::array<std::size_t, validity_count> counts{};    ///< pixel counts by Validity
  std::size_t pixels = 0;
  GreyHistogram histogram{};
  double modulation = 0;    ///< median modulation without points, grey levels of 255
  bool closing = false;     ///< asks whether to close the window
  bool shows_keys = false;  ///< lists mouse and keys
  bool can_undo = false;    ///< a change of the setup can be taken back
  bool measures = false;    ///< the mouse measures; if false, it turns the cloud
  Measured measured;
  std::array<char, 1024> path{};      ///< typed below Files: path to open or to save
  std::vector<std::string> openable;  ///< files beside the one shown
  double drawn_per_second = 0;
  float grid_mm = 0;
  std::string message;  ///< result of the last request: path saved to, or why it failed
};

/// A file to open or to write; without a path the desktop's dialog asks for one.
struct FileRequest {
  FileQuestion question{};
  std::string path{};
};

/// Requests of this frame, by mouse or key.
struct PanelRequests {
  bool fit = false;
  std::optional<Viewpoint> viewpoint{};
  bool save = false;
  bool close = false;
  bool toggle_recording = false;
  bool check_rig = false;
  bool change_setup = false;                  ///< PanelState::setup has changed
  std::optional<ShownControl> set_control{};  ///< camera setting changed
  std::optional<FileRequest> file{};          ///< to open or to write
  const ViewStep* step = nullptr;             ///< the step to begin
  bool expose = false;                        ///< choose the best exposure
  bool undo = false;                          ///< take back the last change of PanelState::setup
  std::optional<std::size_t> scan{};          ///< of the source's scans, to show
};

/// Whether the source has only pictures: frames without a scanner.
bool pictures_alone(const ViewSource& source);

/// Whether the cloud shown has points to write to a file.
bool has_points(const PanelState& state, const ViewSource& source);

/// Whether the camera's exposure can be set, and the best one is known.
bool can_choose_exposure(const PanelState& state, const ViewSource& source);

/// Widths of the panel (left) and the pictures (right), and height of the menus (top), in window
/// units.
struct PanelMargins {
  float left = 0, right = 0, top = 0;
};

/// Hidden parts take no room; small windows have no pictures beside the cloud.
PanelMargins panel_margins(const PanelState& state, const ViewSource& source, const Screen& screen);

/// Draws the left panel: warnings, drawing options, settings, actions, rates.
void draw_panel(PanelState& state, PanelRequests& requests, const ViewSource& source,
                const LiveStatistics& statistics, const Screen& screen);

/// Draws camera picture, histogram, modulation and phase at the right.
void draw_pictures(PanelState& state, const std::array<opengl::PictureTexture, 3>& pictures,
                   const ViewSource& source, const Screen& screen);

/// Explains why a cloud has almost no points; empty if it has some.
std::string why_no_points(const PanelState& state);

}  // namespace slipstream::view
