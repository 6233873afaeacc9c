#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <future>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "slipstream/engine.h"
#include "slipstream/viewer.h"
#include "view/gui.h"
#include "view/opengl.h"
#include "view/orbit_camera.h"
#include "view/scene_renderer.h"

namespace slipstream::view {

/// The first frame in grey, red where any frame is saturated and blue where `validity` is too dark.
/// Large pictures are reduced to about `widest` pixels; single saturated pixels stay visible.
Image<Colour> camera_picture(const FrameViews& frames, int widest,
                             const Image<Validity>* validity = nullptr);

/// Histogram of the frames' grey levels, darkest first: square roots of the counts, the largest 1.
using GreyHistogram = std::array<float, 64>;
GreyHistogram grey_histogram(const FrameViews& frames);

/// Modulation B^c, black at 0 and white at its 99th percentile.
Image<Colour> modulation_picture(const Image<float>& modulation, int widest);

/// Wrapped phase, [0, 2 pi), as hue; dark where the modulation is below `least`.
Image<Colour> phase_picture(const Image<float>& phase, const Image<float>& modulation, float least,
                            int widest);

/// Projection of a cloud onto its drawn picture.
struct CloudOnPicture {
  const Cloud& cloud;
  const Uncertainty* uncertainty = nullptr;  ///< that cloud's; null if unknown
  glm::mat4 clip{1};                         ///< from the scanner's frame
  Size picture;
};

/// The point nearest to the eye within `reach` pixels of a place on the picture.
std::optional<MeasuredPoint> point_under(const CloudOnPicture& shown, const glm::vec2& place,
                                         float reach);

/// The visible points in a rectangle of the picture, given by two opposite corners.
std::vector<MeasuredPoint> points_between(const CloudOnPicture& shown, const glm::vec2& corner,
                                          const glm::vec2& opposite);

/// Measurements made with the mouse.
struct Measured {
  std::vector<MeasuredPoint> ends;  ///< ends of a distance, at most two
  std::vector<std::string> lines;   ///< text shown to the user
};

/// Adds an end of a distance: the second completes it, the third starts a new one.
void add_end(Measured& measured, const MeasuredPoint& point);

/// Replaces the measurement by the plane and the sphere through these points.
void fit_shapes(Measured& measured, std::span<const MeasuredPoint> points);

/// "X 1.23 Y 4.56 Z 789.01 mm, sigma of Z 0.04 mm".
std::string text_of(const MeasuredPoint& point);

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
  bool shown = true;                                   ///< whether panel and pictures are visible
  std::array<bool, 3> picture_open{true, true, true};  ///< camera, modulation, phase
  std::size_t picture = 0;                           ///< the one shown large if there are no points
  std::array<std::size_t, validity_count> counts{};  ///< pixel counts by Validity
  std::size_t pixels = 0;
  GreyHistogram histogram{};
  double modulation = 0;  ///< median modulation without points, grey levels of 255
  bool measures = false;  ///< the mouse measures; if false, it turns the cloud
  Measured measured;
  std::array<char, 1024> path{};      ///< path of the file to open
  std::vector<std::string> openable;  ///< files beside the one shown
  double drawn_per_second = 0;
  float grid_mm = 0;
  std::string message;  ///< result of the last request: path saved to, or why it failed
};

/// Requests of this frame, by mouse or key.
struct PanelRequests {
  bool fit = false;
  std::optional<Viewpoint> viewpoint{};
  bool save = false;
  bool toggle_recording = false;
  bool change_setup = false;                  ///< PanelState::setup has changed
  std::optional<ShownControl> set_control{};  ///< camera setting changed
  std::string open{};                         ///< path; empty: none
  const ViewStep* step = nullptr;             ///< the step to begin
  bool expose = false;                        ///< choose the best exposure
};

/// Whether the source has only pictures: frames without a scanner.
bool pictures_alone(const ViewSource& source);

/// Whether the camera's exposure can be set, and the best one is known.
bool can_choose_exposure(const PanelState& state, const ViewSource& source);

/// Widths of the panel (left) and the pictures (right), in window units.
struct PanelWidths {
  float left = 0, right = 0;
};

/// Hidden parts take no room; small windows have no pictures beside the cloud.
PanelWidths panel_widths(const PanelState& state, const ViewSource& source, const Screen& screen);

/// Draws the left panel: warnings, drawing options, settings, actions, rates.
void draw_panel(PanelState& state, PanelRequests& requests, const ViewSource& source,
                const LiveStatistics& statistics, const Screen& screen);

/// Draws camera picture, histogram, modulation and phase at the right.
void draw_pictures(PanelState& state, const std::array<opengl::PictureTexture, 3>& pictures,
                   const ViewSource& source, const Screen& screen);

/// Explains why a cloud has almost no points; empty if it has some.
std::string why_no_points(const PanelState& state);

/// Draws everything, in a window or off-screen: the cloud between panel and pictures. Uses the
/// OpenGL context current at construction.
class CloudScreen {
 public:
  /// Borrows the source. Takes mouse and keys from the window, if given.
  CloudScreen(const ViewSource& source, const ViewSettings& settings, const opengl::Window* window);
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
  void draw_over(const Area& area, const Screen& screen) const;
  /// Applies the mouse to the cloud: turn, move, measure.
  void take_mouse(const Pane& pane, const Area& area, const Screen& screen);
  void move_camera(const Pane& pane, const Screen& screen);
  void measure(const CloudOnPicture& shown, const Area& area, float pixel_ratio);
  /// Uncertainty of the points, computed on first request for a static cloud; null if unknown.
  const Uncertainty* uncertainty();
  void take_key(int key, PanelRequests& requests);
  void answer(const PanelRequests& requests);
  /// Returns false and shows the reason in the panel if `work` throws.
  template <class Action>
  bool attempt(const Action& action);
  void expose();
  void change_setup();
  void hear_of_changes();
  void ask_camera();
  void save();
  void hear_of_saving();
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
  std::future<std::string> saving_;  ///< awaited on destruction
  int exposures_to_set_ = 0;         ///< until the best one
  std::chrono::steady_clock::time_point exposed_at_;
  std::chrono::steady_clock::time_point counted_since_;
  int counted_ = 0;
};

}  // namespace slipstream::view
