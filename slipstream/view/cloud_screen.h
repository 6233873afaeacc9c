#pragma once

#include <future>
#include <span>
#include <tuple>

#include "slipstream/reconstruct/engine.h"
#include "slipstream/view/viewer.h"

namespace slipstream::view {

/// The first frame in grey, red where any frame is saturated and blue where `validity` says too
/// dark. Large pictures are reduced to about `widest` pixels; a saturated pixel stays visible.
Image<Colour> camera_picture(const FrameViews& frames, int widest,
                             const Image<Validity>* validity = nullptr);

/// Counts of the frames' grey levels, darkest first: their square roots, the largest 1.
using GreyHistogram = std::array<float, 64>;
GreyHistogram grey_histogram(const FrameViews& frames);

/// Modulation B^c, grey levels, black to white from 0 to its 99th percentile.
Image<Colour> modulation_picture(const Image<float>& modulation, int widest);

/// Wrapped phase, [0, 2 pi), once round the hues; dark where the modulation is below `least`.
Image<Colour> phase_picture(const Image<float>& phase, const Image<float>& modulation, float least,
                            int widest);

/// How a cloud lies on the picture that is drawn of it.
struct CloudOnPicture {
  const Cloud& cloud;
  const Uncertainty* uncertainty = nullptr;  ///< of that cloud; null where not known
  glm::mat4 clip{1};                         ///< from the scanner's frame
  Size picture;
};

/// The point nearest to the eye of those drawn within `reach` pixels of a place on the picture.
std::optional<MeasuredPoint> point_under(const CloudOnPicture& shown, const glm::vec2& place,
                                         float reach);

/// The points drawn in a rectangle of the picture between two opposite corners.
std::vector<MeasuredPoint> points_between(const CloudOnPicture& shown, const glm::vec2& corner,
                                          const glm::vec2& opposite);

/// What was measured with the mouse.
struct Measured {
  std::vector<MeasuredPoint> ends;  ///< of a distance, two at most
  std::vector<std::string> lines;   ///< for people
};

/// Another end of a distance: the second one completes it, the third one begins anew.
void add_end(Measured& measured, const MeasuredPoint& point);

/// The plane and the sphere of these points, in place of what was measured before.
void fit_shapes(Measured& measured, std::span<const MeasuredPoint> points);

/// "X 1.23 Y 4.56 Z 789.01 mm, sigma of Z 0.04 mm".
std::string text_of(const MeasuredPoint& point);

/// A setting of the camera, as it was last asked for.
struct ShownControl {
  CameraControl which;
  ControlValue value;
};

/// What can be chosen in the panel, and what it says.
struct PanelState {
  ViewSettings view;
  EngineSetup setup;
  std::size_t strategy = 0, gamma = 0;  ///< of the source's
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
  float left = 0, right = 0;
};

/// Little windows have no room for pictures beside the cloud, and none have any for what is hidden.
PanelWidths panel_widths(const PanelState& state, const ViewSource& source, const Screen& screen);

/// The panel at the left: warnings, how the cloud is drawn, settings, actions, rates.
void draw_panel(PanelState& state, PanelRequests& requests, const ViewSource& source,
                const LiveStatistics& statistics, const Screen& screen);

/// Camera with its histogram, modulation and phase at the right.
void draw_pictures(PanelState& state, const std::array<opengl::PictureTexture, 3>& pictures,
                   const ViewSource& source, const Screen& screen);

/// Why a cloud has next to no points, for people; empty where it has some.
std::string why_no_points(const PanelState& state);

/// All that is drawn into a window or off-screen: the cloud between the panel and the pictures. For
/// the OpenGL context that is current when it is made.
class CloudScreen {
 public:
  /// Borrows the source. With the mouse and keys of the window where there is one.
  CloudScreen(const ViewSource& source, const ViewSettings& settings, const opengl::Window* window);
  /// Takes the newest cloud unless paused; whether it is another than the last.
  bool take_newest();
  /// Draws into the framebuffer that is bound, and does what was asked of it by mouse and keys.
  void draw(const Screen& screen);
  /// Queues a key of GLFW's for the next draw(): none is lost, however long that takes.
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
  /// The frames decoded again; null without frames or where they are of another strategy, as those
  /// just before a change are. Valid until the next call.
  const Maps* maps_of(const FrameViews& frames);
  void draw_scene(const Pane& pane, const Screen& screen);
  void draw_over(const Area& area, const Screen& screen) const;
  /// What the mouse does to the cloud: turns it, moves it, measures it.
  void take_mouse(const Pane& pane, const Area& area, const Screen& screen);
  void move_camera(const Pane& pane, const Screen& screen);
  void measure(const CloudOnPicture& shown, const Area& area, float pixel_ratio);
  /// Of the points, computed when first asked for a cloud that stands still; null if not known.
  const Uncertainty* uncertainty();
  void take_key(int key, PanelRequests& requests);
  void answer(const PanelRequests& requests);
  /// Whether it did not throw; if it did, the panel says why.
  template <class Action>
  bool attempt(const Action& action);
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
  using Look = std::tuple<PointColour, bool, bool, std::array<bool, 3>, std::size_t>;
  [[nodiscard]] Look look() const {
    return {state_.view.colour, state_.view.shaded, state_.shown, state_.picture_open,
            state_.picture};
  }
  Look drawn_;
  std::vector<int> keys_;
  bool closed_ = false;
  std::future<std::string> saving_;  ///< waited for in the end
  std::chrono::steady_clock::time_point counted_since_;
  int counted_ = 0;
};

}  // namespace slipstream::view
