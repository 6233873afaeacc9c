#pragma once

#include <optional>
#include <string>

#include "app/capture.h"
#include "app/commands.h"

namespace slipstream::app {

/// Scans of a fixed scene over time.
struct RepeatFlags {
  std::optional<double> minutes;
  CaptureFlags capture;               ///< source, projector and delay
  std::optional<std::string> report;  ///< folder
};

/// Adds --repeat and the flags of its source, which need it.
void add_repeat_flags(const FlagGroup& command, RepeatFlags& flags);

/// Scans a fixed scene over and over, until the time is over or a signal comes; tells since when
/// its depth is steady, and writes the report. Throws as `capture` if the first scan fails; later
/// ones that fail are left out.
void verify_over_time(const RepeatFlags& flags, Output& output);

}  // namespace slipstream::app
