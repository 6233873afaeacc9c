#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "slipstream/cloud.h"
#include "slipstream/frame_source.h"
#include "slipstream/live_statistics.h"
#include "slipstream/reconstruct_settings.h"
#include "slipstream/surface.h"

namespace slipstream {

/// Cloud of one window of frames, with its frames.
struct LiveCloud {
  Cloud cloud;               ///< empty without a scanner
  ValidityCounts cleaned{};  ///< points that cleaning removed, by reason
  /// The window, in the order given by PatternWindows; frames as captured.
  std::vector<Pooled<Frame>> frames;
  int first_pattern = 0;  ///< index of the first frame's pattern
  int motion = 0;         ///< frames beyond one cycle used for the cloud: see motion_window
  FrameStamp newest;      ///< the frame that completed the window
};

/// Settings of a LivePipeline.
struct LiveSettings {
  PatternIndexing indexing = PatternIndexing::told;
  /// Captured frames that may wait if the source has its own pace; beyond that, the oldest is lost.
  std::size_t waiting_frames = 16;
  /// Clouds that consumers may hold without blocking the pipeline.
  std::size_t held_clouds = 4;
  /// With motion frames: a window with little motion becomes a cloud of its middle cycle alone.
  bool motion_when_seen = false;
  /// Capture ends after this many frames.
  std::optional<std::uint64_t> most_frames = {};
  /// The frames carry pictures of a second camera, see PairedSource, and clouds come from matches
  /// between both, see PhaseMatcher: this camera with the same projector.
  std::optional<Scanner> second_camera = {};
  /// Called for every cloud, in order, in the thread of the show stage; meanwhile clouds and frames
  /// queue up. An exception ends the pipeline.
  std::function<void(const Pooled<LiveCloud>&)> on_cloud = {};
  /// Shape to track in the clouds, and whether to merge them into a model of a rigid object. Each
  /// runs in its own thread and skips clouds that arrive while it is busy.
  std::optional<TrackedShape> track = {};
  bool model = false;
  /// Checks one window per cycle, in pattern order, and returns diagnostics; LiveCheck if empty.
  /// Called in the thread of the reconstruct stage, which waits for it.
  std::function<std::vector<Finding>(const FrameViews& window)> check = {};
};

class LiveRun;
struct WindowEngine;

/// From a source to live clouds: capture, window, reconstruct and show, each in its own thread with
/// a bounded queue before it. Each new frame gives a cloud of the N newest. A source with its own
/// pace never waits: if later stages are too slow, whole windows are skipped and counted, and
/// frames without room are overwritten and counted. Allocates all memory at the start. Without a
/// scanner (see without_geometry) frames are only checked and passed on.
///
/// One thread starts, stops and changes it; any thread may query it.
class LivePipeline {
 public:
  /// Does not start. Throws Error if scanner, strategy or settings are invalid or do not match
  /// frames.
  LivePipeline(std::unique_ptr<FrameSource> source, const EngineSetup& setup,
               const LiveSettings& settings = {});
  ~LivePipeline() { stop(); }

  /// Throws as the source does. Resets all counts.
  void start();
  /// Finishes captured frames if consumers release clouds. May be called twice; restart by start().
  void stop();
  /// True if started and not stopped, the source has not ended and no stage has failed.
  [[nodiscard]] bool running() const;

  /// Blocks until running() is false. Frames captured before that may still become clouds: stop()
  /// waits for them.
  void wait() const;
  /// Exception of a stage, the source or a consumer that ended the pipeline; null if there is none.
  [[nodiscard]] std::exception_ptr failure() const;

  /// Sets settings, strategy and scanner from the next window on. Throws as the constructor does.
  void change(const EngineSetup& setup);

  /// Newest cloud whose window begins with the first pattern, for display; empty before the first.
  /// May be kept while it is shown; capture does not wait for it.
  [[nodiscard]] Pooled<LiveCloud> newest() const;
  /// Call from one thread when a cloud is on screen; `captured`: host_time of its newest frame.
  void shown(std::chrono::steady_clock::time_point captured);

  [[nodiscard]] LiveStatistics statistics() const;
  /// Model of the clouds since the start; no points unless the settings ask for one.
  [[nodiscard]] ModelPoints model() const;
  /// Diagnostics of the frames since the start; LiveStatistics has the current ones. One window per
  /// cycle is checked, before it becomes a cloud.
  [[nodiscard]] std::vector<LiveFinding> findings() const;

 private:
  [[nodiscard]] std::shared_ptr<WindowEngine> plan_for(const EngineSetup& setup);
  [[nodiscard]] std::shared_ptr<LiveRun> run() const;
  /// Queries the last run; an empty answer before the first.
  template <class Answer>
  Answer asked(Answer (LiveRun::*question)() const) const;

  std::unique_ptr<FrameSource> source_;
  FrameFormat format_;
  LiveSettings settings_;
  std::shared_ptr<Pool<Frame>> frames_;
  std::size_t frame_count_ = 0;  ///< size of the pool
  std::shared_ptr<Pool<LiveCloud>> clouds_;
  std::shared_ptr<WindowEngine> plan_;
  bool started_ = false;
  mutable std::mutex mutex_;      ///< guards `run_`
  std::shared_ptr<LiveRun> run_;  ///< the last one, stopped or not
};

}  // namespace slipstream
