#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "app/live.h"
#include "app/monitor_projector.h"
#include "app/rig_guard.h"
#include "frames/stepped_source.h"
#include "io/file_names.h"
#include "io/recorder.h"
#include "slipstream/cloud_sink.h"

namespace slipstream::app {

/// A live scan, from its source to its sinks. The sinks, each in its own thread, query the session,
/// save its clouds and change its settings.
class LiveSession {
 public:
  /// Opens projector, source and pipeline. Throws like these.
  LiveSession(LiveFlags flags, Output& output);
  ~LiveSession() { publisher_.finish(); }  // before the members that its sinks use

  // Main thread:
  /// Opens the sinks and starts.
  void start();
  /// The file. With LiveFlags::new_files a new one, which is another if that one exists; prints its
  /// name. Throws WorldError.
  std::string file_to_write(const std::string& file);
  /// Empty without one from the start.
  [[nodiscard]] const std::string& recording_file() const { return recording_file_; }
  /// Ends the pipeline and the sinks.
  void stop();
  /// Throws WorldError if the recording has failed.
  void finish_recording() { source_->finish_recording(); }
  /// Prints news and warnings of the sinks, and what a guard shows.
  void tell_news();
  [[nodiscard]] bool projector_closed() const { return projector_.closed(); }
  /// The session as a source of clouds; borrows it. In builds with SLIPSTREAM_VIEW.
  view::ViewSource view_source();

  // Any thread:
  [[nodiscard]] bool has_two_cameras() const { return !flags_.second_camera.empty(); }
  [[nodiscard]] const LivePipeline& pipeline() const { return *pipeline_; }
  [[nodiscard]] const RecordedSource& source() const { return *source_; }
  [[nodiscard]] std::vector<SinkStatistics> sinks() const { return publisher_.statistics(); }
  [[nodiscard]] nlohmann::json document() const;  ///< the statistics so far

  [[nodiscard]] EngineSetup setup() const;  ///< in use now
  /// Looks for this sequence from now on. Throws like LivePipeline::change.
  void change(const EngineSetup& setup);

  /// Settings that can change while the session runs: camera, point selection, and recording into a
  /// new file in the --save-to folder.
  [[nodiscard]] std::vector<RunSetting> settings() const;
  /// Throws Error like require_settable, the camera and LivePipeline::change, and WorldError like
  /// RecordedSource.
  void change(const std::string& name, const std::string& value);

  /// Number of changes of setup and camera so far, except the viewer's own of the camera.
  [[nodiscard]] std::uint64_t changes() const { return changes_; }

 private:
  /// The caller holds `mutex_`.
  void change_locked(EngineSetup setup);
  void open_sinks();
  /// Saves frames of that sequence: see save_in_new_folder. Throws Error if there are two cameras,
  /// or the setup has another sequence.
  std::string save(const FrameViews& frames, const Sequence& of_frames,
                   const EngineSetup& setup) const;
  std::string save_newest();

  const LiveFlags flags_;
  Output& output_;
  std::list<NewFile> new_files_;  ///< outlive their writers
  std::string recording_file_;
  MonitorProjector projector_;
  SteppedSource* stepped_ = nullptr;  ///< in step with the projector; null without one
  RecordedSource* source_ = nullptr;  ///< owned by the pipeline
  std::optional<RigWatch> rig_;       ///< nullopt if no guards are taken

  /// Frames come from a projector, not from a rendered or recorded scan.
  const bool patterns_can_change_ = is_camera(flags_.source) && !flags_.monitor;
  bool motion_when_seen_ = false;  ///< see LiveSettings
  Strategy strategy_;              ///< at the start

  mutable std::mutex mutex_;                       ///< guards the setup and pipeline changes
  EngineSetup setup_;                              ///< in use now
  std::atomic<std::uint64_t> changes_{0};          ///< see changes()
  std::mutex saving_;                              ///< guards `saved_`
  std::chrono::steady_clock::time_point saved_{};  ///< the newest cloud; at most one a second
  Publisher publisher_;
  std::unique_ptr<LivePipeline> pipeline_;
};

}  // namespace slipstream::app
