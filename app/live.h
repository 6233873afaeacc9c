#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/source_flags.h"
#include "app/view.h"
#include "slipstream/live_pipeline.h"
#include "slipstream/recording.h"

namespace slipstream::app {

struct LiveFlags {
  SourceFlags source;
  std::optional<int> monitor;  ///< shows the patterns, in step with the camera
  bool no_guard = false;       ///< do not compare rig and scanner
  LiveSettings live;           ///< its flags
  std::optional<double> duration;
  bool headless = false;
  std::string gamma = "scanner";
  ReconstructSettings settings;
  std::string output, model, record;  ///< files; empty: not written
  std::string second_camera;          ///< a source; empty: one camera
  std::optional<fs::path> second_scanner;
  FileLimit limit;  ///< of recordings and MCAP files
  std::vector<std::string> publish;
  ViewFlags view;

  // Only for `serve`:
  bool new_files = false;            ///< replaces no file; see LiveSession::file_to_write
  const Command* command = nullptr;  ///< which read these flags
  std::function<void()> begun;       ///< called once sinks are open and frames are taken
  std::function<bool()> reload;      ///< called when SIGHUP asks for it: whether to end
};

/// Adds the flags of `live` except --headless.
void add_live_flags(const FlagGroup& command, LiveFlags& flags);

/// Throws Error for contradictory flags.
void require_good(const LiveFlags& flags);

/// Runs from source to clouds until the source or a signal ends it.
void live(const LiveFlags& flags, Output& output);

}  // namespace slipstream::app
