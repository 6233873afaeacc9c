#pragma once

#include <chrono>
#include <functional>
#include <utility>

#include "slipstream/check/finding.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/codes/registry.h"
#include "slipstream/codes/response.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/frames/frame_source.h"
#include "slipstream/live/live_statistics.h"
#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/view/gui.h"

namespace slipstream {
class LivePipeline;
}

namespace slipstream::view {

/// A cloud to be shown, and its frames where there are any. Copies share both, which neither change
/// nor leave the memory before the last copy.
struct ShownCloud {
  std::shared_ptr<const Cloud> cloud{};              ///< keeps the memory of the frames too
  std::shared_ptr<const Uncertainty> uncertainty{};  ///< where it came with the cloud
  FrameViews frames{};                               ///< in pattern order; none of a file's cloud
  std::chrono::steady_clock::time_point captured{};  ///< the newest frame; 0 without frames

  /// False before there is a first cloud.
  explicit operator bool() const { return cloud != nullptr; }
  /// Whether it is the very same cloud, not one like it.
  [[nodiscard]] bool is(const ShownCloud& other) const { return cloud == other.cloud; }
};

/// What the viewer shows and what can be asked for in it. Only `newest` must be set; without
/// another function the viewer goes without its part (a button, a key, a section of the panel). The
/// viewer calls `save` from another thread, all others from its own.
struct ViewSource {
  std::string title{};                                   ///< of the window
  std::function<ShownCloud()> newest{};                  ///< asked before each picture
  std::string waits_for = "waiting for the first scan";  ///< said until there is a cloud
  std::function<void(const ShownCloud&)> shown{};  ///< told that the cloud is on the screen now
  std::function<LiveStatistics()> statistics{};    ///< of the pipeline that makes the clouds

  /// At first; a scanner without geometry makes empty clouds, and the frames are looked at. None
  /// for clouds without frames: no pictures beside them, and nothing can be changed or saved.
  std::optional<EngineSetup> setup{};
  std::vector<Finding> findings{};  ///< about frames that come without a pipeline's statistics
  /// Makes clouds with another setup from now on. May throw: the viewer then shows the reason and
  /// keeps the old setup.
  std::function<void(const EngineSetup&)> change{};
  /// The setup of now, where anyone changed it or the camera since the last call.
  std::function<std::optional<EngineSetup>()> changed{};
  std::vector<std::pair<std::string, Strategy>> strategies{};  ///< to choose from, by label
  /// Responses to choose from, by label, that phases are corrected for; none: not corrected.
  std::vector<std::pair<std::string, std::optional<MeasuredResponse>>> gammas{};

  CameraControls* camera = nullptr;  ///< what can be set of it; null where nothing
  std::string camera_region{};       ///< the part of its sensor, for people

  /// What to show instead: a file or a folder. Throws where it cannot be opened.
  std::function<ViewSource(const std::string& path)> open{};
  std::function<std::vector<std::string>()> openable{};  ///< paths to choose from

  /// Writes the cloud's frames and results; returns the folder, for people.
  std::function<std::string(const ShownCloud&, const EngineSetup&)> save{};
  std::function<void(bool on)> record{};  ///< begins or ends a recording
  /// How the recording goes, in a few words; empty where none is made.
  std::function<std::string()> recording{};
};

/// A cloud that stands still, and how sure its points are where that is known.
ViewSource still_source(Cloud cloud, std::optional<Uncertainty> uncertainty = std::nullopt);

/// Frames, reconstructed again for each setup; the caller adds `save`. Throws Error as Engine does.
ViewSource still_source(FrameSet frames, const EngineSetup& setup);

/// The clouds of a running pipeline, which must outlive the source, made by `setup` at first.
/// Offers other responses and, where patterns can change, strategies; the caller adds files.
ViewSource live_source(LivePipeline& pipeline, const EngineSetup& setup, bool patterns_can_change);

/// How the viewer runs.
struct ViewerSettings {
  ViewSettings view;
  Size size{1280, 800};          ///< of the window at first
  double most_per_second = 60;   ///< pictures; one that takes long is followed by a rest
  std::function<bool()> ends{};  ///< polled: whether to close; the user alone decides if empty
  bool keep_last = false;        ///< the last picture is given back
};

/// Opens a window and shows the source until it is closed; in the main thread. Returns what it
/// showed last where that is wanted. Throws WorldError where there is no desktop or no OpenGL 3.3.
std::optional<Image<Colour>> run_viewer(const ViewSource& source, const ViewerSettings& settings);

/// What stands beside the cloud.
enum class Surround { nothing, panel };

/// The viewer's picture of the source's newest cloud, drawn without a window. Throws Error for a
/// size out of range, WorldError without OpenGL.
Image<Colour> render_screen(const ViewSource& source, const ViewSettings& settings, Size size,
                            Surround surround);

/// What a guided person is to see.
struct Guide {
  Image<Colour> picture;
  std::string headline;            ///< large, below the picture
  Colour colour{255, 255, 255};    ///< of the headline
  std::vector<std::string> lines;  ///< below it
};

/// A window that shows a picture and what to do next, its text readable from where the board is. In
/// the main thread.
class GuideWindow {
 public:
  /// Throws WorldError where the desktop or its OpenGL does not give a window.
  GuideWindow(const opengl::WindowSystem& system, const std::string& title, Size size);
  ~GuideWindow();

  void show(Guide guide);
  /// Whether it was closed, or Esc pressed. Answers the desktop meanwhile.
  [[nodiscard]] bool closed() const;
  /// What it showed last.
  [[nodiscard]] Image<Colour> picture();

 private:
  void draw();

  opengl::Window window_;
  Gui gui_;
  opengl::PictureTexture texture_;
  Guide last_;
};

}  // namespace slipstream::view
