#pragma once

#include <memory>

#include "slipstream/capture/frame_source.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/live/live_cloud.h"
#include "slipstream/live/live_statistics.h"
#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/strategy/strategy.h"

namespace slipstream {

/// What is looked for in the frames.
struct LiveScan {
  Scanner scanner;
  Strategy strategy;
  Axis axis = Axis::x;
  ReconstructSettings settings;
};

/// Source to moving cloud: capture, window, reconstruct and show, each on a thread of its own with
/// a bounded queue before it. Each new frame gives a cloud of the N newest.
class LivePipeline {
 public:
  /// Nothing runs yet. Throws Error where scanner, strategy or settings are not valid or do not fit
  /// the source's frames.
  LivePipeline(std::unique_ptr<FrameSource> source, const LiveScan& scan);
  ~LivePipeline();  ///< stops
  LivePipeline(const LivePipeline&) = delete;
  LivePipeline& operator=(const LivePipeline&) = delete;

  void start();
  /// Ends the threads and the source; what was captured is finished first. May be called twice.
  void stop();
  /// Whether it was started, not stopped, and the source has not ended.
  [[nodiscard]] bool running() const;

  /// Other settings, strategy or scanner from the next window on. Throws as the constructor.
  void change(const LiveScan& scan);

  /// The newest cloud, for display; empty before the first. The share may be kept for as long as it
  /// is shown; capture does not wait for it.
  [[nodiscard]] Pooled<LiveCloud> newest() const;
  /// Tells that a cloud of that capture is on the screen now.
  void shown(const LiveCloud& cloud);

  [[nodiscard]] LiveStatistics statistics() const;

 private:
  class Stages;
  std::unique_ptr<Stages> stages_;
};

}  // namespace slipstream
