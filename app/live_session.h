#pragma once

#include <functional>

#include "app/output.h"
#include "slipstream/io/recorded_source.h"
#include "slipstream/live/live_pipeline.h"

namespace slipstream::app {

/// A live scan that runs, for what shows it.
struct LiveSession {
  LivePipeline& pipeline;  ///< started
  RecordedSource& recorder;
  LiveScan scan;
  /// Whether it is to end: asked for, all frames there, time over, or failed.
  std::function<bool()> is_over;
};

/// Shows it in a window until that is closed or the session is over.
void show_in_window(LiveSession& session, Output& output);  // with SLIPSTREAM_VIEW

}  // namespace slipstream::app
