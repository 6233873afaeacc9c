#pragma once

#include <map>
#include <optional>
#include <string>

#include <CLI/App.hpp>

#include "slipstream/base/size.h"
#include "slipstream/codes/sequence_changes.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream::app {

/// The flags that say what patterns a scan is made of, as far as they were given.
struct ScanFlags {
  std::optional<std::string> strategy;
  std::map<std::string, std::optional<std::string>> settings;  ///< by the setting's name
  std::optional<std::string> period_pixels;                    ///< "64,60.2"
  std::optional<double> stripe_pixels;
  std::optional<std::string> axis;
  std::optional<std::string> projector;  ///< "1824x1140"
  std::optional<double> alpha_p;
  std::optional<double> beta_p;
  std::optional<std::string> exposures;  ///< "1,4,16"
  std::optional<std::string> order;      ///< of frames: "2,0,1"
  bool marker = false;
  bool binary = false;
  std::optional<int> motion;
};

/// Adds --strategy, a flag for each setting of the registry, --axis, --projector, --alpha-p,
/// --beta-p, --exposures, --motion and --binary.
void add_pattern_flags(CLI::App& subcommand, ScanFlags& flags);

/// Adds --marker, for what shows patterns again and again, or sees them.
void add_marker_flag(CLI::App& subcommand, ScanFlags& flags);

/// Adds those of add_pattern_flags but --binary, and --order, for what reads scans.
void add_scan_flags(CLI::App& subcommand, ScanFlags& flags);

/// What they say, by the library's words. Throws Error for an axis or a size that is none.
SequenceChanges changes_from(const ScanFlags& flags);

/// The same and the order.
ScanChanges scan_changes_from(const ScanFlags& flags);

/// "1824x1140". Throws Error, naming the flag, for anything else.
Size size_from(const std::string& text, const std::string& flag);

}  // namespace slipstream::app
