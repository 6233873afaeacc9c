#pragma once

#include <array>
#include <chrono>
#include <future>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "slipstream/reconstruct/engine.h"
#include "slipstream/view/gui.h"
#include "slipstream/view/measuring.h"
#include "slipstream/view/opengl.h"
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
  /// A key of GLFW's that was pressed, for the next draw(): none is lost, however long that takes.
  void press(int key) { keys_.push_back(key); }
  /// Tells the source that what draw() drew is on the screen now.
  void tell_shown();

  /// Opens a file in place of the source, see ViewSource::open; says in the panel why not.
  void open(const std::string& path);
  /// What was opened since the last call.
  std::optional<ViewSource> take_opened() { return std::exchange(opened_, std::nullopt); }
  [[nodiscard]] PanelState& state() { return state_; }
  /// Whether the window is to be closed: its key was pressed.
  [[nodiscard]] bool closed() const { return closed_; }

 private:
  void set_cloud(const ShownCloud& shown);
  void set_pictures(const ShownCloud& shown);
  void update_pictures(const FrameViews& frames, const Maps* maps);
  [[nodiscard]] int width_of(std::size_t picture) const;
  /// What the frames say, decoded again when it is looked at; null where there are none or they are
  /// of another strategy, as those just before a change are. Valid until the next call.
  const Maps* maps_of(const FrameViews& frames);
  void draw_scene(const Pane& pane, const Screen& screen);
  void draw_over(const Area& area, const Screen& screen) const;
  /// What the mouse does to the cloud: turns it, moves it, measures it.
  void take_mouse(const Pane& pane, const Area& area, const Screen& screen);
  void move_camera(const Pane& pane, const Screen& screen);
  void measure(const CloudOnPicture& shown, const Area& area, float pixel_ratio);
  /// How sure the points are, worked out when it is first asked for a cloud that stands still; null
  /// where that is not known.
  const Uncertainty* uncertainty();
  void take_keys(PanelRequests& requests);
  void take_key(int key, PanelRequests& requests);
  void answer(const PanelRequests& requests);
  /// Whether it did not throw; if it did, the panel says why.
  template <class Action>
  bool attempt(const Action& action);
  void change_setup();
  void hear_of_changes();
  void set_control(const ShownControl& asked);
  void ask_camera();
  void save();
  void hear_of_saving();
  void count_drawn();

  const ViewSource& source_;
  Gui gui_;
  SceneRenderer scene_;
  std::array<opengl::PictureTexture, 3> pictures_;
  std::optional<Engine> engine_;  ///< of the setup accepted last; none where the source has none
  Maps maps_;
  double maps_full_scale_ = 255;  ///< of the frames that they are of
  Image<Validity> validity_;      ///< of the pictures, where there are no points
  Image<float> shading_;
  std::optional<Uncertainty> uncertainty_;  ///< of the cloud shown
  std::optional<ViewSource> opened_;
  PanelState state_;
  std::pair<std::size_t, std::size_t> accepted_;  ///< strategy and gamma of the setup
  ShownCloud cloud_;
  bool told_shown_ = true;
  bool fitted_ = false, fit_wanted_ = false;
  /// What the cloud in the graphics memory and the pictures were made for.
  struct Look {
    PointColour colour = PointColour::reflectivity;
    bool shaded = false, shown = false;
    std::array<bool, 3> picture_open{};
    std::size_t picture = 0;

    friend bool operator==(const Look&, const Look&) = default;
  };
  [[nodiscard]] Look look() const;
  Look drawn_;
  std::vector<int> keys_;
  bool closed_ = false;
  std::future<std::string> saving_;
  std::chrono::steady_clock::time_point counted_since_;
  int counted_ = 0;
};

}  // namespace slipstream::view
