#include "app/finding_output.h"

namespace slipstream::app {

nlohmann::json json_of(const Finding& finding) {
  nlohmann::json evidence = nlohmann::json::object();
  for (const auto& [name, value] : finding.evidence) evidence[name] = value;
  return {{"what", finding.what},
          {"evidence", evidence},
          {"likely", finding.likely},
          {"try", finding.advice},
          {"refused", finding.gravity == Gravity::wrong}};
}

void warn_of(const std::vector<Finding>& findings, Output& output) {
  for (const Finding& finding : findings) output.warn(text_of(finding));
}

}  // namespace slipstream::app
