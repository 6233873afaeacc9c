#pragma once

#include <atomic>

#include "app/source_flags.h"
#include "slipstream/frames/frame_source.h"
#include "slipstream/io/recorder.h"
#include "slipstream/live/live_pipeline.h"
#include "slipstream/publish/cloud_sink.h"
#include "slipstream/view/scene_renderer.h"
#include "slipstream/view/viewer.h"

namespace slipstream::app {

/// Flags of everything that draws clouds.
struct ViewFlags {
  std::string snapshot;    ///< picture without the panel; no file if empty
  std::string screenshot;  ///< picture with it
  Size size{1280, 800};
  view::ViewSettings settings{};
  std::string save_to = ".";
};

struct LiveFlags {
  SourceFlags source;
  std::optional<int> monitor;  ///< shows the patterns, in step with the camera
  LiveSettings live;           ///< its flags
  std::optional<double> duration;
  bool headless = false;
  std::string gamma = "scanner";
  ReconstructSettings settings;
  std::string output, model, record;  ///< files; empty: not written
  FileLimit limit;                    ///< of recordings and MCAP files
  std::vector<std::string> publish;
  ViewFlags view;
  // Of serve:
  const RigSaid* rig = nullptr;      ///< the file's contents
  std::function<LiveFlags()> again;  ///< rereads the file; throws Error
  std::function<void()> begun;       ///< called once sinks are open and frames are taken
  std::function<bool()> hung_up;     ///< at SIGHUP: whether to end
};

/// Runs from source to clouds until the source or a signal ends it.
void live(const LiveFlags& flags, Output& output);

/// A running live scan, as a display sees it.
struct LiveSession {
  const LiveFlags& flags;
  LivePipeline& pipeline;
  RecordedSource& recorder;
  EngineSetup setup;  ///< in use now; see setup_of
  /// Whether to end: requested, all frames taken, time over, or failed.
  std::function<bool()> is_over;
  bool patterns_can_change;  ///< frames come from a projector, not from a rendered or recorded scan
  bool motion_when_seen;     ///< see LiveSettings
  Strategy strategy;         ///< at the start
  std::mutex mutex{};        ///< guards the setup and pipeline changes
  std::atomic<std::uint64_t> changes{0};  ///< of setup and camera, except the viewer's own
};

/// Whether motion compensation is possible: the patterns are one sinusoid shown repeatedly, and the
/// fused pass decodes them.
bool takes_motion(const Sequence& sequence);

/// The setup in use. Callable from any thread, like the next three.
EngineSetup setup_of(LiveSession& session);
/// Looks for this sequence from now on. Throws like LivePipeline::change.
void change_setup(LiveSession& session, const EngineSetup& setup);

/// Settings that can change while the session runs: camera, point selection, and recording into a
/// new file in the --save-to folder.
std::vector<RunSetting> settings_of(LiveSession& session);
/// Throws Error like require_settable, the camera and LivePipeline::change, and WorldError like
/// RecordedSource.
void change_setting(LiveSession& session, const std::string& name, const std::string& value);

/// Opens the --publish sinks before the session starts. `document` returns the current --json
/// document; called from any thread.
void open_sinks(LiveSession& session, const std::function<nlohmann::json()>& document,
                Publisher& publisher);

/// Save in viewer and page: writes frames and results into a new folder in `parent`, named by the
/// time, which reconstruct can read. `remarks` go into the cloud's header, see doubts. Without a
/// scanner no points are written; frames merged from several exposures are not written. Returns the
/// folder. Throws Error if the frames do not fit the setup's strategy, WorldError if they cannot be
/// written.
std::string save_in_new_folder(const FrameViews& frames, const EngineSetup& setup,
                               const std::string& parent, const std::vector<std::string>& remarks);

// These are there with SLIPSTREAM_VIEW:

/// Adds --snapshot, --screenshot, --size, --colour and --save-to.
void add_view_flags(CLI::App& subcommand, ViewFlags& flags);

/// Throws Error for a picture file with an unknown extension.
void require_good(const ViewFlags& flags);

/// Shows the session in a window until either ends; then writes the requested screenshot.
void show_in_window(LiveSession& session, Output& output);

/// Draws the newest cloud without a window and writes the requested pictures. Throws WorldError
/// without a cloud.
void draw_newest(LiveSession& session, bool screenshot_too, Output& output);

/// The windows of `capture`, and the projector of `live`.
struct DesktopWishes {
  std::optional<int> monitor{};  ///< the projector
  bool guides = false;           ///< the window that guides the user with a board
  Size size{};                   ///< of the guide window
};

/// The projector, if it is a monitor, and the guide window, as requested.
struct CaptureDesktop {
  PatternSink* projector = nullptr;
  double refresh_hz = 0;                          ///< the projector's
  std::function<void(view::Guide guide)> show{};  ///< in the window that guides; empty without
  /// Whether a window was closed. Answers the desktop meanwhile.
  std::function<bool()> closed = [] { return false; };
  std::function<Image<Colour>()> picture{};  ///< the guide window's last picture
};

/// Throws Error for a missing monitor or a build without windows, WorldError without a desktop.
CaptureDesktop open_desktop(const DesktopWishes& wishes);

}  // namespace slipstream::app
