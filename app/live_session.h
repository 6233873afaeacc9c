#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

#include "app/output.h"
#include "app/view_flags.h"
#include "slipstream/io/recorded_source.h"
#include "slipstream/live/live_pipeline.h"

namespace slipstream::app {

/// A live scan that runs, for what shows it.
struct LiveSession {
  LivePipeline& pipeline;
  RecordedSource& recorder;
  EngineSetup setup;  ///< what is looked for in the frames now; see live_settings.h
  /// Whether it is to end: asked for, all frames there, time over, or failed.
  std::function<bool()> is_over;
  std::string source;        ///< as it was asked for
  bool patterns_can_change;  ///< the frames show what a projector shows, not what is in memory
  bool motion_when_seen;     ///< as LiveSettings has it
  Strategy strategy;         ///< at the start
  ViewFlags view;
  std::mutex mutex{};                     ///< of the setup and of what changes the pipeline
  std::atomic<std::uint64_t> changes{0};  ///< of setup and camera, but for the viewer's of that
};

/// Shows it in a window until that is closed or the session is over; then writes the screenshot
/// that the flags ask for. With SLIPSTREAM_VIEW, as the next.
void show_in_window(LiveSession& session, Output& output);

/// Writes the pictures that the flags ask for, drawn without a window, of the newest cloud. Throws
/// WorldError where there is none.
void draw_newest(LiveSession& session, bool screenshot_too, Output& output);

}  // namespace slipstream::app
