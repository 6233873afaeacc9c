#pragma once

#include <array>
#include <chrono>
#include <future>
#include <string>

#include "slipstream/opengl/picture_texture.h"
#include "slipstream/view/frame_decoding.h"
#include "slipstream/view/gui.h"
#include "slipstream/view/panel.h"
#include "slipstream/view/scene_renderer.h"
#include "slipstream/view/view_source.h"

namespace slipstream::view {

/// All that is drawn into a window, or into a picture off-screen: the cloud between the panel and
/// the pictures. For the OpenGL context that is current when it is made.
class LiveScreen {
 public:
  /// Borrows the source. With the mouse and keys of the window where there is one.
  LiveScreen(const ViewSource& source, const ViewSettings& settings, const opengl::Window* window);
  LiveScreen(const LiveScreen&) = delete;
  LiveScreen& operator=(const LiveScreen&) = delete;
  ~LiveScreen() = default;  ///< waits for what is being saved

  /// Takes the newest cloud unless paused; whether it is another than the last.
  bool take_newest();
  /// Draws into the framebuffer that is bound, and does what was asked of it by mouse and keys.
  void draw(const Screen& screen);
  /// Tells the source that what draw() drew is on the screen now.
  void tell_shown();

  [[nodiscard]] PanelState& state() { return state_; }

 private:
  void set_cloud(const LiveCloud& cloud);
  void update_pictures(const LiveCloud& cloud, const FusedDecoding* decoding);
  void move_camera(const Pane& pane, const Screen& screen);
  void take_keys(PanelRequests& requests);
  void answer(const PanelRequests& requests);
  void change_scan();
  void save();
  void hear_of_saving();
  void count_drawn();

  const ViewSource& source_;
  Gui gui_;
  SceneRenderer scene_;
  std::array<opengl::PictureTexture, 3> pictures_;
  FrameDecoding decoding_;
  bool decodes_ = false;
  PanelState state_;
  LiveScan accepted_scan_;
  std::size_t accepted_strategy_ = 0, accepted_gamma_ = 0;
  Pooled<LiveCloud> cloud_;
  bool told_shown_ = true;
  bool fitted_ = false, fit_wanted_ = false;
  PointColour drawn_colour_ = PointColour::reflectivity;
  std::array<bool, 3> drawn_open_{};
  std::future<std::string> saving_;
  std::chrono::steady_clock::time_point counted_since_;
  int counted_ = 0;
};

}  // namespace slipstream::view
