#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "app/source_flags.h"
#include "frames/stepped_source.h"
#include "io/recorder.h"
#include "slipstream/cloud_sink.h"
#include "slipstream/live_pipeline.h"
#include "slipstream/recording.h"
#include "slipstream/viewer.h"
#include "view/scene_renderer.h"

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
  std::string second_camera;          ///< a source; empty: one camera
  std::optional<fs::path> second_scanner;
  FileLimit limit;  ///< of recordings and MCAP files
  std::vector<std::string> publish;
  ViewFlags view;

  // Of serve:
  const RigSaid* rig = nullptr;      ///< the file's contents
  std::function<LiveFlags()> again;  ///< rereads the file; throws Error
  std::function<void()> begun;       ///< called once sinks are open and frames are taken
  std::function<bool()> hung_up;     ///< at SIGHUP: whether to end
};

/// Adds the flags of `live` except --headless.
void add_live_flags(const FlagGroup& command, LiveFlags& flags);

/// Runs from source to clouds until the source or a signal ends it.
void live(const LiveFlags& flags, Output& output);

/// Throws WorldError without a desktop, Error for a build without windows; before work of seconds.
void require_desktop();

/// A monitor that shows the patterns.
struct MonitorProjector {
  PatternSink* sink = nullptr;  ///< null: none was requested
  double refresh_hz = 0;
  /// Whether its window was closed. Processes window events; main thread.
  std::function<bool()> closed = [] { return false; };
};

/// Throws Error for a missing monitor or a build without windows, WorldError without a desktop.
MonitorProjector open_projector(std::optional<int> monitor);

/// A live scan, from its source to its sinks.
struct LiveSession {
  /// Opens projector, source and pipeline. Throws like these.
  LiveSession(LiveFlags given, Output& output);
  ~LiveSession() { publisher.finish(); }  // before the members that its sinks use

  /// Opens the sinks and starts.
  void start();

  const LiveFlags flags;
  Output& output;
  MonitorProjector projector{};
  const SteppedSource* stepped = nullptr;  ///< in step with the projector; null without one
  RecordedSource* recorder = nullptr;      ///< owned by the pipeline
  EngineSetup setup{};                     ///< in use now; see setup_of

  /// Whether to end: requested, all frames taken, time over, or failed.
  std::function<bool()> is_over = [] { return false; };
  bool patterns_can_change;  ///< frames come from a projector, not from a rendered or recorded scan
  bool motion_when_seen;     ///< see LiveSettings
  Strategy strategy;         ///< at the start

  std::mutex mutex{};                             ///< guards the setup and pipeline changes
  std::mutex saving{};                            ///< guards `saved`
  std::chrono::steady_clock::time_point saved{};  ///< the newest cloud; at most one a second
  std::atomic<std::uint64_t> changes{0};          ///< of setup and camera, except the viewer's own
  Publisher publisher;
  std::unique_ptr<LivePipeline> pipeline;
};

/// Labels of this strategy, and of common ones that a projector may show instead.
std::vector<std::string> strategy_labels(const Strategy& given);

/// Whether motion compensation is possible: the patterns are one sinusoid, or PCMP's two in the
/// same frames, shown repeatedly.
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

/// Throws Error if the session's clouds cannot be saved.
void require_saveable(const LiveSession& session);

/// Opens the --publish sinks before the session starts. `document` returns the current --json
/// document; called from any thread.
void open_sinks(LiveSession& session, const std::function<nlohmann::json()>& document);

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

/// Draws --snapshot and, if requested, --screenshot without a window. Throws WorldError without a
/// cloud.
void write_pictures(const view::ViewSource& source, const ViewFlags& flags, bool screenshot_too,
                    Output& output);

/// The session as a source of clouds; borrows it.
view::ViewSource view_source_of(LiveSession& session);

/// A scan, a recording or a cloud, named `path`.
view::ViewSource view_source_of(const std::string& path, const CloudFlags& flags,
                                const ViewFlags& view, Output& output);

/// Viewable scan folders and files in a folder, newest first.
std::vector<std::string> viewable_in(const fs::path& folder);

/// One window from camera and projector to a cloud; the flags are its first choices.
void studio(const LiveFlags& flags, Output& output);

}  // namespace slipstream::app
