#include "app/finding_output.h"

namespace slipstream::app {

nlohmann::json json_of(const Finding& finding) {
  nlohmann::json evidence = nlohmann::json::object();
  for (const auto& [name, value] : finding.evidence) evidence[name] = value;
  return {{"what", finding.what},
          {"evidence", std::move(evidence)},
          {"likely", finding.likely},
          {"try", finding.advice},
          {"refused", finding.gravity == Gravity::wrong}};
}

nlohmann::json json_of(const std::vector<Finding>& findings) {
  nlohmann::json list = nlohmann::json::array();
  for (const Finding& finding : findings) list.push_back(json_of(finding));
  return list;
}

void warn_of(const std::vector<Finding>& findings, Output& output) {
  for (const Finding& finding : findings) output.warn(text_of(finding));
}

}  // namespace slipstream::app
