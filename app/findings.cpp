#include "app/findings.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/flag_group.h"

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

nlohmann::json json_of(const ValidityCounts& counts) {
  nlohmann::json named = nlohmann::json::object();
  for (std::size_t i = 0; i < validity_count; ++i) {
    named[std::string(name_of(static_cast<Validity>(i)))] = counts[i];
  }
  return named;
}

void warn_of(const std::vector<Finding>& findings, Output& output) {
  for (const Finding& finding : findings) output.warn(text_of(finding));
}

void add_anyway_flag(CLI::App& subcommand, bool& anyway) {
  const FlagGroup group{subcommand};
  group.add("--anyway", anyway, "go on where the check refuses the scan, and mark the results");
}

void refuse_or_warn(const CheckedScan& checked, const std::string& scan, bool anyway,
                    Output& output) {
  if (!anyway && any_wrong(checked.findings)) {
    output.document["findings"] = json_of(gravest_first(checked.findings));
    require_right(checked, scan);
  }
  for (const Finding& finding : checked.findings) {
    output.warn(fmt::format("{}: {}", scan, text_of(finding)));
  }
  for (const std::string& repair : checked.repairs) output.say("{}: {}", scan, repair);
}

void tell_news(const std::vector<LiveFinding>& findings, std::vector<LiveFinding>& told,
               Output& output) {
  for (const LiveFinding& now : findings) {
    const auto before = std::find_if(told.begin(), told.end(), [&](const LiveFinding& other) {
      return other.begin == now.begin && other.finding.what == now.finding.what;
    });
    if (before == told.end()) output.warn(fmt::format("frames: {}", text_of(now.finding)));
    if (now.end && (before == told.end() || !before->end)) {
      output.say("frames: {}: this has ended, {} frames after it began", now.finding.what,
                 *now.end - now.begin);
    }
  }
  told = findings;
}

nlohmann::json json_of(const std::vector<LiveFinding>& findings) {
  nlohmann::json listed = nlohmann::json::array();
  for (const auto& [finding, begin, end] : findings) {
    nlohmann::json told = app::json_of(finding);
    told["begin"] = begin;
    told["end"] = end ? nlohmann::json(*end) : nlohmann::json();
    listed.push_back(std::move(told));
  }
  return listed;
}

bool warn_of_gpu(const std::string& failure, Output& output) {
  if (failure.empty()) return false;
  output.warn(failure + "; the processor goes on");
  return true;
}

}  // namespace slipstream::app
