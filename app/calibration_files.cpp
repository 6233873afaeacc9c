#include "app/calibration_files.h"

#include <utility>

#include <fmt/format.h>

#include "app/flag_group.h"
#include "app/progress.h"
#include "app/scan_findings.h"
#include "slipstream/base/error.h"
#include "slipstream/io/photometric_file.h"
#include "slipstream/io/saved_scan.h"

namespace slipstream::app {
namespace fs = std::filesystem;

void add_calibration_files(CLI::App& command, CalibrationFiles& files) {
  const FlagGroup group{command};
  group.add_file("--scanner", files.scanner, "scanner file to add to; where not that of the scan");
  group.add_scanner_output("-o,--output", files.output, "the scanner file to write: .yaml or .xml");
}

void for_each_scan(const std::vector<std::string>& folders, const ScanFlags& flags,
                   CalibrationFiles& files, bool of_gamma, Output& output,
                   const std::function<void(const Scan& scan, const std::string& folder)>& take) {
  Progress progress("scans", static_cast<int>(folders.size()));
  for (const std::string& folder : folders) {
    ScanFiles described = scan_files_in(folder, scan_changes_from(flags));
    if (files.scanner) described.scanner = *files.scanner;
    Scan scan = load_frames(described);
    for (const std::string& warning : scan.warnings) output.warn(warning);
    CheckedScan checked = check_and_repair(scan);
    if (of_gamma) checked.findings = without_cause(std::move(checked.findings), gamma_is_to_blame);
    refuse_or_warn(checked, folder, false, output);
    if (!files.scanner && described.scanner) files.scanner = described.scanner->string();
    try {
      take(scan, folder);
    } catch (const Error& error) {
      const std::string message = error.what();
      throw Error(message.starts_with(folder) ? message : fmt::format("{}: {}", folder, message));
    }
    progress.advance();
  }
}

void write_calibration(const CalibrationFiles& files, const PhotometricCalibration& found,
                       Output& output) {
  require_valid(found);
  if (files.output.empty()) {
    output.say("nothing was asked to be written; -o scanner.yaml writes it into a scanner file");
    return;
  }
  std::optional<fs::path> from;
  if (files.scanner) from = *files.scanner;
  write_photometric_calibration(from, files.output, found);
  output.document["output"] = files.output;
  output.say("{}: written{}", files.output,
             from ? fmt::format(", with all that {} holds", from->string()) : "");
}

BarPlot bar_plot(const std::string& title, const std::string& unit, const Histogram& counted) {
  return {title,       unit,         "pixels",
          counted.low, counted.high, {counted.counts.begin(), counted.counts.end()}};
}

}  // namespace slipstream::app
