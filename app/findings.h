#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "app/output.h"
#include "slipstream/check/finding.h"
#include "slipstream/check/scan_check.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/live/live_statistics.h"

namespace slipstream::app {

/// As the JSON document says it: `what`, `evidence` by name, `likely`, `try`, `refused`.
nlohmann::json json_of(const Finding& finding);

nlohmann::json json_of(const std::vector<Finding>& findings);

/// By the names of the reasons.
nlohmann::json json_of(const ValidityCounts& counts);

/// A warning for each.
void warn_of(const std::vector<Finding>& findings, Output& output);

/// Adds --anyway.
void add_anyway_flag(CLI::App& subcommand, bool& anyway);

/// Warns of all that is doubtful and says what was repaired. Where something is wrong throws Error,
/// naming the scan and all findings, what is wrong first; with `anyway` it warns of that too.
void refuse_or_warn(const CheckedScan& checked, const std::string& scan, bool anyway,
                    Output& output);

/// Warns of each finding that has begun since `told`, and says which of them have ended; they are
/// told then.
void tell_news(const std::vector<LiveFinding>& findings, std::vector<LiveFinding>& told,
               Output& output);

/// As a finding of a scan, with `begin` and `end`: sequence of the frames at which it was first
/// told and first gone; null where it lasts.
nlohmann::json json_of(const std::vector<LiveFinding>& findings);

/// Warns of Engine::gpu_failure; false where there is none.
bool warn_of_gpu(const std::string& failure, Output& output);

}  // namespace slipstream::app
