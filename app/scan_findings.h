#pragma once

#include <string>

#include <CLI/App.hpp>

#include "app/output.h"
#include "slipstream/check/checked_scan.h"

namespace slipstream::app {

/// Adds --anyway.
void add_anyway_flag(CLI::App& subcommand, bool& anyway);

/// Warns of all that is doubtful and says what was repaired. Where something is wrong throws Error,
/// naming the scan and all findings, what is wrong first; with `anyway` it warns of that too.
void refuse_or_warn(const CheckedScan& checked, const std::string& scan, bool anyway,
                    Output& output);

}  // namespace slipstream::app
