#include <string>
#include <vector>

#include "app/commands.h"
#include "app/findings.h"
#include "app/output.h"
#include "app/scan_input.h"

namespace slipstream::app {
namespace {

struct CheckFlags {
  std::vector<std::string> folders;
  ScanInputFlags input;
  CheckSettings settings;
};

void tell_findings(const std::string& folder, const std::vector<Finding>& findings,
                   Output& output) {
  if (findings.empty()) output.say("{}: nothing amiss", folder);
  for (const Finding& finding : findings) {
    output.say("{}: {}: {}", folder, finding.gravity == Gravity::wrong ? "wrong" : "doubtful",
               text_of(finding));
  }
}

void check(const CheckFlags& flags, Output& output) {
  output.document["scans"] = nlohmann::json::array();
  Progress progress("scans", static_cast<int>(flags.folders.size()));
  for (const std::string& folder : flags.folders) {
    Scan scan = load_checkable(folder, flags.input, true, output);
    CheckSettings settings = flags.settings;
    settings.photometry = flags.input.photometry;
    settings.photometry.response = choose_response(scan, flags.input.gamma).response;
    const std::vector<Finding> findings = check_and_repair(scan, settings).findings;
    if (any_wrong(findings)) output.exit_code = 2;
    output.list("scans").push_back({{"scan", folder}, {"findings", app::json_of(findings)}});
    progress.finish();
    tell_findings(folder, findings, output);
    progress.advance();
  }
}

}  // namespace

void add_check(CLI::App& program, Command& chosen) {
  const auto [command, flags] =
      add_command(program, chosen, check, "check",
                  "whether the frames of scans fit their patterns, the scanner and each other");
  command
      .add_file("folders", flags.folders,
                "scan folders (pictures, and scan.yaml or flags) or recordings")
      ->required();
  command.add("--min-modulation", flags.settings.minimum_modulation,
              "of a pixel that becomes a point, grey levels of 255 whatever the camera's bits");
  add_scan_input_flags(command.app, flags.input);
  command.app.footer(
      "Examples:\n  slipstream check scan\n  slipstream check frames --strategy pmp --steps 4\n"
      "Without a scanner less can be told. It ends with 2 where a scan is wrong, so that "
      "reconstruct would refuse it.");
}

}  // namespace slipstream::app
