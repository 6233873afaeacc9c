#pragma once

#include "slipstream/cloud/object_model.h"
#include "slipstream/frames/pattern_windows.h"
#include "slipstream/live/live_cloud.h"
#include "slipstream/live/live_statistics.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream {

/// How a LivePipeline goes about it.
struct LiveSettings {
  PatternIndexing indexing = PatternIndexing::told;
  /// Captured frames of a source with its own pace that may wait before the oldest is overwritten.
  std::size_t waiting_frames = 16;
  /// Clouds that consumers may hold at a time without keeping the pipeline waiting.
  std::size_t held_clouds = 4;
  /// With frames for motion: a window in which little moves becomes a cloud of its middle cycle.
  bool motion_when_seen = false;
  /// Capture ends after so many.
  std::optional<std::uint64_t> most_frames = {};
  /// Called for every cloud, in order, in the thread of the show stage; while it takes its time
  /// clouds and frames queue up before it. What it throws ends the pipeline.
  std::function<void(const Pooled<LiveCloud>&)> on_cloud = {};
  /// Each in a thread of its own, which misses clouds that come meanwhile: what is looked for in
  /// the clouds, and whether they become one model of a rigid object.
  std::optional<TrackedShape> track = {};
  bool model = false;
  /// What looks at a window of each cycle, in pattern order, and says what is amiss; LiveCheck
  /// where it is empty. Called in the thread of the reconstruct stage, which waits for it.
  std::function<std::vector<Finding>(const FrameViews& window)> check = {};
};

class LiveRun;
struct WindowEngine;

/// Source to moving cloud: capture, window, reconstruct and show, each on a thread of its own with
/// a bounded queue before it. Each new frame gives a cloud of the N newest. A source with its own
/// pace never waits: what finds no room is overwritten and counted. All memory is allocated at the
/// start. Without a scanner (see without_geometry) only frames are checked and handed on.
///
/// One thread starts, stops and changes it; any may ask.
class LivePipeline {
 public:
  /// Not started. Throws Error if scanner, strategy or settings are invalid or do not fit frames.
  LivePipeline(std::unique_ptr<FrameSource> source, const EngineSetup& setup,
               const LiveSettings& settings = {});
  ~LivePipeline();  ///< stops

  /// Throws where the source does. What was counted before is forgotten.
  void start();
  /// Finishes what was captured, if consumers let clouds go. It may be called twice; start() again.
  void stop();
  /// Whether it was started, not stopped, and neither has the source ended nor a stage failed.
  [[nodiscard]] bool running() const;
  /// What a stage, the source or a consumer threw, which ended the pipeline; else null.
  [[nodiscard]] std::exception_ptr failure() const;

  /// Other settings, strategy or scanner from the next window on. Throws as the constructor.
  void change(const EngineSetup& setup);

  /// The newest cloud whose window begins with the first pattern, for display; empty before it. The
  /// share may be kept for as long as it is shown; capture does not wait for it.
  [[nodiscard]] Pooled<LiveCloud> newest() const;
  /// A cloud is on the screen now; `captured`: host_time of its newest frame. From one thread.
  void shown(std::chrono::steady_clock::time_point captured);

  [[nodiscard]] LiveStatistics statistics() const;
  /// What the clouds since the start have become; no points where the settings want no model.
  [[nodiscard]] ModelPoints model() const;
  /// What was found amiss with the frames since the start, and when; see LiveStatistics for what is
  /// amiss now. The check looks at one window of each cycle, before it becomes a cloud.
  [[nodiscard]] std::vector<LiveFinding> findings() const;

 private:
  [[nodiscard]] std::shared_ptr<WindowEngine> plan_for(const EngineSetup& setup);
  [[nodiscard]] std::shared_ptr<LiveRun> run() const;
  /// What the last run answers; before the first, an empty answer.
  template <class Answer>
  Answer asked(Answer (LiveRun::*question)() const) const;

  std::unique_ptr<FrameSource> source_;
  FrameFormat format_;
  LiveSettings settings_;
  std::shared_ptr<Pool<Frame>> frames_;
  std::size_t frame_count_ = 0;  ///< of that pool
  std::shared_ptr<Pool<LiveCloud>> clouds_;
  std::shared_ptr<WindowEngine> plan_;
  bool started_ = false;
  mutable std::mutex mutex_;      ///< of what follows
  std::shared_ptr<LiveRun> run_;  ///< the last one; stopped or not
};

}  // namespace slipstream
