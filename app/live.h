#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/clean_flags.h"
#include "app/flag_group.h"
#include "app/output.h"
#include "app/rig_flag.h"
#include "app/source_flags.h"
#include "app/view_flags.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream::app {

struct LiveFlags {
  SourceFlags source;
  std::optional<double> duration;
  std::optional<std::uint64_t> frames;
  bool headless = false;
  std::string indexing = "told";
  std::string gamma = "scanner", backend = "fused";
  ReconstructSettings settings;
  CleanFlags clean;
  std::string track, model;
  std::string output;
  std::string record;
  std::vector<std::string> publish;
  ViewFlags view;
  // Of serve:
  const RigSaid* rig = nullptr;      ///< what its file says
  std::function<LiveFlags()> again;  ///< what the flags are by the file as it is now; throws Error
  std::function<void()> begun;       ///< called once sinks are open and frames are taken
  /// At SIGHUP: whether it is to end.
  std::function<bool()> hung_up;
};

/// Adds all but --headless.
void add_live_flags(const FlagGroup& command, LiveFlags& flags);

/// Tells systemd, where it started the program and wants to know: "READY=1", "STATUS=...".
void tell_service_manager(const std::string& state);

/// Throws Error for what cannot be meant, as far as that is known before anything is opened.
void require_good(const LiveFlags& flags);

/// From the source to clouds until it ends, or a signal ends it.
void live(const LiveFlags& flags, Output& output);

}  // namespace slipstream::app
