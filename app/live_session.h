#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>

#include "app/live.h"
#include "app/monitor_projector.h"
#include "frames/stepped_source.h"
#include "io/recorder.h"
#include "slipstream/cloud_sink.h"
#include "slipstream/live_pipeline.h"

namespace slipstream::app {

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

/// The statistics so far, also for the sinks.
nlohmann::json document_of(const LiveSession& session);

/// Prints news and warnings of the sinks.
void tell_news(Publisher& publisher, Output& output);

}  // namespace slipstream::app
