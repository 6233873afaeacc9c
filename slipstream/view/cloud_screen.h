#pragma once

#include <array>
#include <chrono>
#include <future>
#include <optional>
#include <string>

#include "slipstream/opengl/picture_texture.h"
#include "slipstream/reconstruct/engine.h"
#include "slipstream/view/gui.h"
#include "slipstream/view/panel.h"
#include "slipstream/view/scene_renderer.h"
#include "slipstream/view/view_source.h"

namespace slipstream::view {

/// All that is drawn into a window, or into a picture off-screen: the cloud between the panel and
/// the pictures. For the OpenGL context that is current when it is made.
class CloudScreen {
 public:
  /// Borrows the source. With the mouse and keys of the window where there is one.
  CloudScreen(const ViewSource& source, const ViewSettings& settings, const opengl::Window* window);
  CloudScreen(const CloudScreen&) = delete;
  CloudScreen& operator=(const CloudScreen&) = delete;
  ~CloudScreen() = default;  ///< waits for what is being saved

  /// Takes the newest cloud unless paused; whether it is another than the last.
  bool take_newest();
  /// Draws into the framebuffer that is bound, and does what was asked of it by mouse and keys.
  void draw(const Screen& screen);
  /// Tells the source that what draw() drew is on the screen now.
  void tell_shown();

  [[nodiscard]] PanelState& state() { return state_; }

 private:
  void set_cloud(const ShownCloud& shown);
  void update_pictures(const FrameViews& frames, const Maps* maps);
  /// What the frames say, decoded again when it is looked at; null where there are none or they are
  /// of another strategy, as those just before a change are. Valid until the next call.
  const Maps* maps_of(const FrameViews& frames);
  void move_camera(const Pane& pane, const Screen& screen);
  void take_keys(PanelRequests& requests);
  void answer(const PanelRequests& requests);
  void change_setup();
  void save();
  void hear_of_saving();
  void count_drawn();

  const ViewSource& source_;
  Gui gui_;
  SceneRenderer scene_;
  std::array<opengl::PictureTexture, 3> pictures_;
  std::optional<Engine> engine_;  ///< of the setup accepted last; none where the source has none
  Maps maps_;
  PanelState state_;
  std::size_t accepted_strategy_ = 0, accepted_gamma_ = 0;
  ShownCloud cloud_;
  bool told_shown_ = true;
  bool fitted_ = false, fit_wanted_ = false;
  PointColour drawn_colour_ = PointColour::reflectivity;
  std::array<bool, 3> drawn_open_{};
  std::future<std::string> saving_;
  std::chrono::steady_clock::time_point counted_since_;
  int counted_ = 0;
};

}  // namespace slipstream::view
