#pragma once

#include <vector>

#include "app/output.h"
#include "slipstream/check/finding.h"

namespace slipstream::app {

/// As the JSON document says it: `what`, `evidence` by name, `likely`, `try`, `refused`.
nlohmann::json json_of(const Finding& finding);

nlohmann::json json_of(const std::vector<Finding>& findings);

/// A warning for each.
void warn_of(const std::vector<Finding>& findings, Output& output);

}  // namespace slipstream::app
