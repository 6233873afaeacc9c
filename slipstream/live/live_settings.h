#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "slipstream/check/finding.h"
#include "slipstream/frames/frame_views.h"
#include "slipstream/frames/pattern_indexing.h"
#include "slipstream/frames/pool.h"
#include "slipstream/live/live_cloud.h"
#include "slipstream/live/object_track.h"

namespace slipstream {

/// How a LivePipeline goes about it.
struct LiveSettings {
  PatternIndexing indexing = PatternIndexing::told;
  /// Captured frames that may wait, where the source has its own pace; then the oldest is
  /// overwritten. A source without waits for the one after the next.
  std::size_t waiting_frames = 16;
  /// Clouds that consumers may hold at a time without keeping the pipeline waiting.
  std::size_t held_clouds = 4;
  /// Of a sequence with frames beyond a cycle: a window in which little moves becomes the cloud of
  /// its middle cycle alone, in less time.
  bool motion_when_seen = false;
  /// Capture ends after so many.
  std::optional<std::uint64_t> most_frames = {};
  /// Called for every cloud, in order, in the thread of the show stage; while it takes its time
  /// clouds and frames queue up before it. What it throws ends the pipeline.
  std::function<void(const Pooled<LiveCloud>&)> on_cloud = {};
  /// What is looked for in the clouds, and whether they become one model of a rigid object, each in
  /// a thread of its own: clouds that come meanwhile are missed.
  std::optional<TrackedShape> track = {};
  bool model = false;
  /// What looks at a window of each cycle, in pattern order, and says what is amiss; LiveCheck
  /// where it is empty. Called in the thread of the reconstruct stage, which waits for it.
  std::function<std::vector<Finding>(const FrameViews& window)> check = {};
};

}  // namespace slipstream
