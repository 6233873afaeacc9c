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

/// The flags of all that draws clouds.
struct ViewFlags {
  std::string snapshot;    ///< picture without the panel; no file if empty
  std::string screenshot;  ///< picture with it
  Size size{1280, 800};
  view::ViewSettings settings{};
  std::string save_to = ".";
};

struct LiveFlags {
  SourceFlags source;
  LiveSettings live;  ///< what flags say of it
  std::optional<double> duration;
  bool headless = false;
  std::string gamma = "scanner";
  ReconstructSettings settings;
  std::string output, model, record;  ///< files; none where empty
  std::vector<std::string> publish;
  ViewFlags view;
  // Of serve:
  const RigSaid* rig = nullptr;      ///< what its file says
  std::function<LiveFlags()> again;  ///< the flags by the file as it is now; throws Error
  std::function<void()> begun;       ///< called once sinks are open and frames are taken
  std::function<bool()> hung_up;     ///< at SIGHUP: whether it is to end
};

/// From the source to clouds until it ends, or a signal ends it.
void live(const LiveFlags& flags, Output& output);

/// A live scan that runs, for what shows it.
struct LiveSession {
  const LiveFlags& flags;
  LivePipeline& pipeline;
  RecordedSource& recorder;
  EngineSetup setup;  ///< what is looked for in the frames now; see setup_of
  /// Whether it is to end: asked for, all frames there, time over, or failed.
  std::function<bool()> is_over;
  bool patterns_can_change;  ///< the frames show what a projector shows, not what is in memory
  bool motion_when_seen;     ///< as LiveSettings has it
  Strategy strategy;         ///< at the start
  std::mutex mutex{};        ///< of the setup and of what changes the pipeline
  std::atomic<std::uint64_t> changes{0};  ///< of setup and camera, but for the viewer's of that
};

/// Whether windows of more than a cycle may do for things that move: the patterns are one sinusoid
/// shown over and over, and are read by the fused pass.
bool takes_motion(const Sequence& sequence);

/// What is looked for in the frames now. From any thread, as the next three.
EngineSetup setup_of(LiveSession& session);
/// Looks for that in the frames from now on. Throws as LivePipeline::change.
void change_setup(LiveSession& session, const EngineSetup& setup);

/// What can be changed while the session runs: of the camera, of what becomes points, and the
/// recording, into a new file in the folder of --save-to.
std::vector<RunSetting> settings_of(LiveSession& session);
/// Throws Error as require_settable, as the camera and as LivePipeline::change, WorldError as
/// RecordedSource.
void change_setting(LiveSession& session, const std::string& name, const std::string& value);

/// Opens the sinks that --publish names for a session that has not begun; `document`: what --json
/// would say now, called from any thread.
void open_sinks(LiveSession& session, const std::function<nlohmann::json()>& document,
                Publisher& publisher);

/// What Save does in viewer and page: writes frames, and all that is made of them, into a new
/// folder in `parent` named by the time, which reconstruct reads again. `remarks` are for the
/// cloud's header, see doubts. Without a scanner there are no points to write; frames that were
/// merged from several exposures are not written, the scan has them. Returns the folder.
/// Throws Error if the frames are not of the setup's strategy, WorldError if they cannot be
/// written.
std::string save_in_new_folder(const FrameViews& frames, const EngineSetup& setup,
                               const std::string& parent, const std::vector<std::string>& remarks);

// These are there with SLIPSTREAM_VIEW:

/// Adds --snapshot, --screenshot, --size, --colour and --save-to.
void add_view_flags(CLI::App& subcommand, ViewFlags& flags);

/// Throws Error for a picture file of unknown ending.
void require_good(const ViewFlags& flags);

/// Shows it in a window until that is closed or the session is over; then writes the screenshot
/// that the flags ask for.
void show_in_window(LiveSession& session, Output& output);

/// Writes the pictures that the flags ask for, drawn without a window, of the newest cloud. Throws
/// WorldError without one.
void draw_newest(LiveSession& session, bool screenshot_too, Output& output);

/// What `capture` opens on the desktop.
struct DesktopWishes {
  std::optional<int> monitor{};  ///< the projector
  bool guides = false;           ///< a window that guides a person with a board
  Size size{};                   ///< of that window
};

/// The projector, if it is a monitor, and the window that guides, as far as they are wished.
struct CaptureDesktop {
  PatternSink* projector = nullptr;
  std::function<void(view::Guide guide)> show{};  ///< in the window that guides; empty without
  /// Whether a window was closed. Answers the desktop meanwhile.
  std::function<bool()> closed = [] { return false; };
  std::function<Image<Colour>()> picture{};  ///< what that window showed last
};

/// Throws Error for a monitor that is not there or a build without windows, WorldError without a
/// desktop.
CaptureDesktop open_desktop(const DesktopWishes& wishes);

}  // namespace slipstream::app
