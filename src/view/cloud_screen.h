#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "slipstream/engine.h"
#include "slipstream/viewer.h"
#include "view/file_dialog.h"
#include "view/gui.h"
#include "view/measuring.h"
#include "view/opengl.h"
#include "view/orbit_camera.h"
#include "view/panel.h"
#include "view/pictures.h"
#include "view/scene_renderer.h"

namespace slipstream::view {

/// Draws everything, in a window or off-screen: the cloud between panel and pictures. Uses the
/// OpenGL context current at construction.
class CloudScreen {
 public:
  /// Borrows the source. Takes mouse and keys from the window, if given.
  CloudScreen(const ViewSource& source, const ViewSettings& settings, const opengl::Window* window);
  CloudScreen(const CloudScreen&) = delete;
  CloudScreen& operator=(const CloudScreen&) = delete;
  ~CloudScreen() { given_up_ = true; }
  /// Takes the newest cloud unless paused; returns whether it is new.
  bool take_newest();
  /// Draws into the bound framebuffer and handles mouse and keys.
  void draw(const Screen& screen);
  /// Queues a GLFW key for the next draw(), so that slow drawing loses none.
  void press(int key) { keys_.push_back(key); }
  /// Notifies the source that the drawn cloud is on the screen.
  void tell_shown();

  /// Opens a file instead of the source, see ViewSource::open; shows errors in the panel.
  void open(const std::string& path);
  /// Applies the panel's setup; false if it is refused, with the reason in the panel.
  bool change_setup();
  /// Opens a file or writes the cloud shown to it; without a path a dialog asks for one.
  void take_file(const FileRequest& request);
  /// Makes the source to show instead; call it after this one is gone. Empty without one.
  std::function<ViewSource()> take_next() { return std::exchange(next_, nullptr); }
  [[nodiscard]] PanelState& state() { return state_; }
  /// Whether the key to close the window was pressed.
  [[nodiscard]] bool closed() const { return closed_; }

 private:
  void set_cloud();
  void set_pictures();
  void update_pictures(const FrameViews& frames, const Maps* maps);
  [[nodiscard]] int width_of(std::size_t picture) const;
  /// Decodes the frames again; null without frames, or if they belong to another strategy, e.g.
  /// just before a change. Valid until the next call.
  const Maps* maps_of(const FrameViews& frames);
  void draw_scene(const Pane& pane, const Screen& screen);
  [[nodiscard]] Area above_timeline(Area area) const;
  void draw_over(const Area& area, const Screen& screen) const;
  /// Applies the mouse to the cloud: turn, move, measure.
  void take_mouse(const Pane& pane, const Area& area, const Screen& screen);
  /// Uncertainty of the points, computed on first request for a static cloud; null if unknown.
  const Uncertainty* uncertainty();
  void take_key(int key, PanelRequests& requests);
  void answer(const PanelRequests& requests);
  /// Returns false and shows the reason in the panel if `work` throws.
  bool attempt(const std::function<void()>& action);
  void expose();
  void undo();
  /// Shows a scan of a recording; the next one, if it is due.
  void show_scan(std::size_t number);
  void play();
  void hear_of_changes();
  void choose_as_in(const EngineSetup& setup);
  void ask_camera();
  void save();
  void hear_of_saving();
  void hear_of_dialog();
  /// Writes the cloud shown, or its surface, in the format of the path's ending.
  void write(const std::string& path);
  void count_drawn();

  const ViewSource& source_;
  Gui gui_;
  SceneRenderer scene_;
  std::array<opengl::PictureTexture, 3> pictures_;
  std::optional<Engine> engine_;  ///< for the setup accepted last; null if the source has none
  Maps maps_;
  double maps_full_scale_ = 255;  ///< of their frames
  Image<Validity> validity_;      ///< for pictures without points
  Image<float> shading_;
  std::optional<Uncertainty> uncertainty_;  ///< of the displayed cloud
  std::function<ViewSource()> next_;
  const ViewStep* beginning_ = nullptr;  ///< after it is drawn once more
  Guide guide_;
  opengl::PictureTexture guide_picture_;
  PanelState state_;
  std::pair<std::size_t, std::size_t> accepted_;  ///< the setup's strategy and gamma
  std::vector<EngineSetup> earlier_;              ///< setups before each change
  std::chrono::steady_clock::time_point scan_shown_at_;
  ShownCloud cloud_;
  bool told_shown_ = true;
  bool fitted_ = false, fit_wanted_ = false;
  /// State for which the uploaded cloud and pictures were made.
  using Look = std::tuple<PointColour, bool, bool, std::array<bool, 3>, std::size_t>;
  [[nodiscard]] Look look() const {
    return {state_.view.colour, state_.view.shaded, state_.shown, state_.picture_open,
            state_.picture};
  }
  Look drawn_;
  std::vector<int> keys_;
  bool closed_ = false;
  std::future<std::string> saving_;     ///< awaited on destruction
  std::atomic<bool> given_up_ = false;  ///< ends the question
  FileQuestion asked_{};
  std::future<std::optional<std::string>> asking_;  ///< for a file; awaited on destruction
  /// Tried until the best: saturated pixels hide how bright they are.
  static constexpr int most_exposures = 4;
  int exposures_to_set_ = 0;  ///< until the best one
  std::chrono::steady_clock::time_point exposed_at_;
  std::chrono::steady_clock::time_point counted_since_;
  int counted_ = 0;
};

}  // namespace slipstream::view
