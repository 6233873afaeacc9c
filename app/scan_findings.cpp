#include "app/scan_findings.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/finding_output.h"
#include "app/flag_group.h"
#include "slipstream/check/mistaken_orders.h"
#include "slipstream/error/error.h"

namespace slipstream::app {
namespace {

void check_camera(Scan& camera, const CheckSettings& settings, const std::string& name,
                  CheckedScan& checked) {
  ScanFindings found = check_scan(camera, settings);
  for (Finding& finding : found.findings) {
    finding.what = name + finding.what;
    checked.findings.push_back(std::move(finding));
  }
  if (found.order.empty()) return;
  camera.frames = reordered(std::move(camera.frames), found.order);
  camera.order = composed(camera.order, found.order);
  checked.repairs.push_back(
      fmt::format("{}frames put in the order {}", name, fmt::join(camera.order, ",")));
}

}  // namespace

void add_anyway_flag(CLI::App& subcommand, bool& anyway) {
  const FlagGroup group{subcommand};
  group.add("--anyway", anyway, "go on where the check refuses the scan, and mark the results");
}

CheckedScan check_and_repair(Scan& scan, const CheckSettings& settings) {
  CheckedScan checked;
  check_camera(scan, settings, "", checked);
  for (std::size_t i = 0; i < scan.further_cameras.size(); ++i) {
    check_camera(scan.further_cameras[i], settings, fmt::format("camera {}: ", i + 2), checked);
  }
  if (!scan.further_cameras.empty()) {
    checked.findings = without_cause(std::move(checked.findings), gamma_is_to_blame);
  }
  return checked;
}

void refuse_or_warn(const CheckedScan& checked, const std::string& scan, bool anyway,
                    Output& output) {
  if (any_wrong(checked.findings) && !anyway) {
    std::vector<Finding> findings = checked.findings;
    std::stable_partition(findings.begin(), findings.end(),
                          [](const Finding& finding) { return finding.gravity == Gravity::wrong; });
    std::vector<std::string> texts;
    for (const Finding& finding : findings) texts.push_back(text_of(finding));
    output.document["findings"] = json_of(findings);
    throw Error(fmt::format("{}: {}", scan, fmt::join(texts, " | ")));
  }
  for (const Finding& finding : checked.findings) {
    output.warn(fmt::format("{}: {}", scan, text_of(finding)));
  }
  for (const std::string& repair : checked.repairs) output.say("{}: {}", scan, repair);
}

std::vector<std::string> doubts(const std::vector<Finding>& findings) {
  std::vector<std::string> lines;
  for (const Finding& finding : findings) {
    if (finding.gravity == Gravity::wrong) {
      lines.push_back(fmt::format("doubted: {}", text_of(finding)));
    }
  }
  return lines;
}

}  // namespace slipstream::app
