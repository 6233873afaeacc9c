#include "app/scan_findings.h"

#include <fmt/format.h>

#include "app/finding_output.h"
#include "app/flag_group.h"

namespace slipstream::app {

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

}  // namespace slipstream::app
