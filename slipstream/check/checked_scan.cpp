#include "slipstream/check/checked_scan.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/error.h"
#include "slipstream/check/mistaken_orders.h"

namespace slipstream {
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

std::vector<Finding> gravest_first(std::vector<Finding> findings) {
  std::stable_partition(findings.begin(), findings.end(),
                        [](const Finding& finding) { return finding.gravity == Gravity::wrong; });
  return findings;
}

void require_right(const CheckedScan& checked, const std::string& scan) {
  if (!any_wrong(checked.findings)) return;
  std::vector<std::string> texts;
  for (const Finding& finding : gravest_first(checked.findings)) texts.push_back(text_of(finding));
  throw Error(fmt::format("{}: {}", scan, fmt::join(texts, " | ")));
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

}  // namespace slipstream
