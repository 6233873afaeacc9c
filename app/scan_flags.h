#pragma once

#include <string>

#include "app/flag_group.h"
#include "slipstream/base/size.h"
#include "slipstream/codes/sequence.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream::app {

/// Adds --strategy, a flag for each setting of the registry, --axis, --projector, --alpha-p,
/// --beta-p, --exposures, --motion and --binary. A switch also has its opposite: --no-backwards.
void add_pattern_flags(CLI::App& subcommand, SequenceChanges& changes);

/// Adds --marker, for what shows patterns again and again, or sees them.
void add_marker_flag(CLI::App& subcommand, SequenceChanges& changes);

/// Adds those of add_pattern_flags but --binary, and --order, for what reads scans.
void add_scan_flags(CLI::App& subcommand, ScanChanges& changes);

/// Whether the word is a flag that switches a setting of patterns on.
bool is_pattern_switch(const std::string& word);

/// Adds --size.
void add_size_flag(const FlagGroup& group, Size& size, const std::string& help);

/// "1824x1140". Throws Error, naming the flag, for anything else.
Size size_from(const std::string& text, const std::string& flag);

}  // namespace slipstream::app
