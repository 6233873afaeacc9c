#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "app/output.h"
#include "slipstream/check/finding.h"

namespace slipstream::app {

/// {"what", "evidence": {name: value}, "likely", "try", "refused"}.
nlohmann::json json_of(const Finding& finding);

/// A warning on stderr for each.
void warn_of(const std::vector<Finding>& findings, Output& output);

}  // namespace slipstream::app
