#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "slipstream/capture/frame.h"
#include "slipstream/capture/frame_views.h"
#include "slipstream/capture/pool.h"
#include "slipstream/check/finding.h"
#include "slipstream/live/live_cloud.h"

namespace slipstream {

/// How it is known which pattern a frame shows. Whichever it is, the pictures are watched, and a
/// slipped index is set right: see PatternWindows.
enum class PatternIndexing {
  told,     ///< by the source, FrameStamp::pattern_index; frames that lack it are counted on
  counted,  ///< the frame's sequence modulo the patterns: the projector triggers the camera
  marker,   ///< a dark or bright frame before the first pattern of each cycle of N + 1 frames
};

/// "told", "counted", "marker".
std::string_view name_of(PatternIndexing indexing);
/// Throws Error for any other name.
PatternIndexing pattern_indexing_named(std::string_view name);
std::vector<std::string_view> pattern_indexing_names();

/// How a LivePipeline goes about it.
struct LiveSettings {
  PatternIndexing indexing = PatternIndexing::told;
  /// Captured frames that may wait, where the source has its own pace; then the oldest is
  /// overwritten. A source without waits for the one after the next.
  std::size_t waiting_frames = 16;
  /// Clouds that consumers may hold at a time without keeping the pipeline waiting.
  std::size_t held_clouds = 4;
  /// Capture ends after so many.
  std::optional<std::uint64_t> most_frames = {};
  /// Called for every cloud, in order, in the thread of the show stage; while it takes its time
  /// clouds and frames queue up before it. What it throws ends the pipeline.
  std::function<void(const Pooled<LiveCloud>&)> on_cloud = {};
  /// What looks at a window of each cycle, in pattern order, and says what is amiss; LiveCheck
  /// where it is empty. Called in the thread of the reconstruct stage, which waits for it.
  std::function<std::vector<Finding>(const FrameViews& window)> check = {};
};

}  // namespace slipstream
