#pragma once

#include <vector>

#include "app/output.h"
#include "slipstream/check/finding.h"
#include "slipstream/live/finding_log.h"

namespace slipstream::app {

/// As the JSON document says it: `what`, `evidence` by name, `likely`, `try`, `refused`.
nlohmann::json json_of(const Finding& finding);

nlohmann::json json_of(const std::vector<Finding>& findings);

/// A warning for each.
void warn_of(const std::vector<Finding>& findings, Output& output);

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
