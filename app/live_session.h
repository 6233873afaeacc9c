#pragma once

#include <functional>
#include <string>

#include "slipstream/io/recorded_source.h"
#include "slipstream/live/live_pipeline.h"

#ifdef SLIPSTREAM_VIEW
#include "app/view_flags.h"
#include "slipstream/view/viewer.h"
#endif

namespace slipstream::app {

/// A live scan that runs, for what shows it.
struct LiveSession {
  LivePipeline& pipeline;  ///< started
  RecordedSource& recorder;
  LiveScan scan;
  /// Whether it is to end: asked for, all frames there, time over, or failed.
  std::function<bool()> is_over;
};

#ifdef SLIPSTREAM_VIEW
/// Shows it in a window until that is closed or the session is over. Throws WorldError where there
/// is no desktop.
void show_in_window(LiveSession& session, const ViewFlags& flags);

/// The newest cloud as a picture file, drawn without a window.
void write_picture(LiveSession& session, const ViewFlags& flags, const std::string& path,
                   view::Surround surround);
#endif

}  // namespace slipstream::app
