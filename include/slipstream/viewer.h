#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "slipstream/check.h"
#include "slipstream/cloud.h"
#include "slipstream/engine.h"
#include "slipstream/frame_set.h"
#include "slipstream/frame_source.h"
#include "slipstream/image.h"
#include "slipstream/live_pipeline.h"
#include "slipstream/response.h"
#include "slipstream/strategy.h"

namespace slipstream {
class LivePipeline;
}

namespace slipstream::view {

/// The viewpoint: a place on a sphere around a target; upright like the scanner's camera if all
/// angles are 0. The display's frame is the scanner's after half a turn about X: Y is up and the
/// cloud shows its front.
struct OrbitCamera {
  glm::vec3 target{0};         ///< display's frame, mm
  float distance = 1000;       ///< mm, > 0
  float azimuth = 0;           ///< rad, to the right
  float elevation = 0;         ///< rad, up; within a right angle
  float field_of_view = 0.6F;  ///< field of view from top to bottom, rad
};

/// Quantity shown by a point's colour.
enum class PointColour {
  depth,         ///< Z
  reflectivity,  ///< alpha, from the mean without ambient light, Liu 2010, Eq. (3.3)
  modulation,    ///< B^c
  camera,        ///< the colour camera's; without one, as reflectivity
};

/// Parses "depth", "reflectivity", "modulation" or "camera"; throws Error for any other name.
PointColour point_colour_named(std::string_view name);
std::vector<std::string_view> point_colour_names();

/// Drawing options of a cloud.
struct ViewSettings {
  PointColour colour = PointColour::depth;
  float point_size = 1.5F;  ///< point size relative to the point spacing: no gaps from 1
  float brightness = 1;     ///< of grey levels; at 1 the brightest 1 % is white
  bool shaded = true;       ///< shades by slope, if the cloud is a camera's grid
  bool reflection = false;  ///< reflection in the floor, parallel to the XZ plane
  bool axes = true;
  bool grid = true;          ///< the floor's
  bool three_views = false;  ///< from the front, the side and above side by side, fitted
  OrbitCamera camera{.azimuth = 0.33F, .elevation = 0.22F};
};

/// A picture and instructions below it, readable from a calibration board's distance.
struct Guide {
  Image<Colour> picture;
  std::string headline{};            ///< large, below the picture
  Colour colour{255, 255, 255};      ///< of the headline
  std::vector<std::string> lines{};  ///< below it
};

/// A cloud to show, with its frames if there are any. Copies share both, which stay unchanged and
/// in memory until the last copy is gone.
struct ShownCloud {
  std::shared_ptr<const Cloud> cloud{};              ///< also keeps the frames' memory
  std::shared_ptr<const Uncertainty> uncertainty{};  ///< if it came with the cloud
  FrameViews frames{};                               ///< in pattern order; empty for a cloud file
  std::vector<Finding> findings{};                   ///< about the frames; empty for live ones
  std::shared_ptr<const Sequence> sequence{};        ///< of live frames; null for others
  std::chrono::steady_clock::time_point captured{};  ///< the newest frame; 0 without frames

  /// False before the first cloud.
  explicit operator bool() const { return cloud != nullptr; }
  /// Whether it is the identical cloud object.
  [[nodiscard]] bool is(const ShownCloud& other) const { return cloud == other.cloud; }
};

struct ViewSource;

/// A choice in the panel: one of `options`, or any text if there are none.
struct ViewChoice {
  std::string name;
  std::string help{};
  std::vector<std::string> options{};
  std::string value{};
};

/// A button that ends the source and begins the returned one.
struct ViewStep {
  std::string name;
  int key = 0;  ///< GLFW's
  std::string help{};
  std::function<ViewSource()> begin{};
};

/// How to get to another source. Sources share it, so that choices stay.
struct ViewSteps {
  std::vector<ViewChoice> choices{};
  std::vector<ViewStep> buttons{};  ///< apply the choices
  std::string message{};            ///< result of the last step, or why it failed
};

/// Content and functions of a viewer. Only `newest` is required; without another function the
/// viewer omits its button, key or panel section. The viewer calls `save` from another thread, all
/// others from its own.
struct ViewSource {
  std::string title{};                                   ///< window title
  std::function<ShownCloud()> newest{};                  ///< called before each picture
  std::string waits_for = "waiting for the first scan";  ///< shown until the first cloud
  std::function<void(const ShownCloud&)> shown{};        ///< called when the cloud is on the screen
  std::function<LiveStatistics()> statistics{};          ///< of the pipeline making the clouds

  /// Initial setup; a scanner without geometry makes empty clouds, and the frames are shown.
  /// nullopt for clouds without frames: no pictures beside them, and nothing can be changed or
  /// saved.
  std::optional<EngineSetup> setup{};
  /// Makes clouds with another setup from now on. May throw: the viewer then shows the reason and
  /// keeps the old setup.
  std::function<void(const EngineSetup&)> change{};
  /// The current setup, if it or the camera has changed since the last call.
  std::function<std::optional<EngineSetup>()> changed{};
  std::vector<std::pair<std::string, Strategy>> strategies{};  ///< choices, by label
  /// Choices of response correction, by label; nullopt: not corrected.
  std::vector<std::pair<std::string, std::optional<MeasuredResponse>>> gammas{};

  /// The scans of a recording, one of which `newest` gives: their number, the time from one to the
  /// next, s, and a function that chooses one. It may throw: the viewer then shows the reason.
  std::size_t scans = 1;
  double seconds_per_scan = 0;
  std::function<void(std::size_t)> show_scan{};

  CameraControls* camera = nullptr;  ///< camera controls; null if none
  /// The exposure, ms, that measures most pixels of such a scene, from a cloud taken with
  /// `exposure`. May throw: the viewer then shows the reason.
  std::function<double(const ShownCloud&, double exposure)> best_exposure{};
  std::string camera_region{};  ///< region of its sensor, as text

  /// Opens a file or a folder to show instead; nullopt if it only changes a choice of `steps`.
  /// Throws if it cannot be opened.
  std::function<std::optional<ViewSource>(const std::string& path)> open{};
  std::function<std::vector<std::string>()> openable{};  ///< paths offered to open

  /// Writes the cloud's frames and results; returns the folder, as text.
  std::function<std::string(const ShownCloud&, const EngineSetup&)> save{};
  std::function<void(bool on)> record{};  ///< starts or stops a recording
  /// Status of the recording in a few words; empty if there is none.
  std::function<std::string()> recording{};
  std::function<void()> check_rig{};   ///< compares the rig with its calibration
  std::function<std::string()> rig{};  ///< result of the newest comparison; empty before
  bool opens_saved = false;  ///< Save also opens the saved scan; its button is called Capture

  std::shared_ptr<ViewSteps> steps{};  ///< null if there is only this source
  /// Instructions shown in place of the cloud, if they are new; see Guide.
  std::function<std::optional<Guide>()> guide{};

  /// Frame whose axes are drawn and in which coordinates are shown; null: the camera's. Clouds are
  /// given in the camera's.
  std::shared_ptr<const FramePose> frame{};

  /// How messages and findings that name settings in backquotes are shown, see Error; empty: as
  /// they are.
  std::function<std::string(std::string_view text)> wording{};
  [[nodiscard]] std::string worded(std::string_view text) const {
    return wording ? wording(text) : std::string(text);
  }
};

/// A static cloud, with its uncertainty if known.
ViewSource still_source(Cloud cloud, std::optional<Uncertainty> uncertainty = std::nullopt);

/// The frames of a scan.
struct StillScan {
  FrameSet frames;
  Image<Colour> colour{};           ///< of their pixels; empty: unknown
  std::vector<Finding> findings{};  ///< about them
};

/// A scan, reconstructed again for each setup; the caller adds `save`. `scan_at`: reads others, for
/// ViewSource::show_scan. Throws Error like Engine.
ViewSource still_source(StillScan scan, const EngineSetup& setup,
                        std::function<StillScan(std::size_t)> scan_at = {});

/// The clouds of a running pipeline, which must outlive the source; `setup`: the initial one.
/// Offers other responses and, if patterns can change, strategies; the caller adds files.
ViewSource live_source(LivePipeline& pipeline, const EngineSetup& setup, bool patterns_can_change);

struct ViewerSettings {
  ViewSettings view{};
  Size size{1280, 800};          ///< initial window size
  std::function<bool()> ends{};  ///< polled: whether to close; empty: only the user closes it
  bool keep_last = false;        ///< return the last picture
};

/// Opens a window and shows the source until it is closed or the desktop ends; frees it before
/// another one is made. Main thread only. Returns the last picture if requested and drawn. Throws
/// WorldError without a desktop or OpenGL 3.3.
std::optional<Image<Colour>> run_viewer(ViewSource source, const ViewerSettings& settings);

/// Parts shown beside the cloud.
enum class Surround { nothing, panel };

/// The viewer's picture of the source's newest cloud, drawn without a window. Throws Error for a
/// size out of range, WorldError without OpenGL.
Image<Colour> render_screen(const ViewSource& source, const ViewSettings& settings, Size size,
                            Surround surround);

}  // namespace slipstream::view
