#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/calibration_files.h"
#include "app/commands.h"
#include "slipstream/decode/reflectivity.h"
#include "slipstream/io/photometric_file.h"
#include "slipstream/io/plot_file.h"
#include "slipstream/response/ambient_calibration.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct CalibrateAmbientFlags {
  std::vector<std::string> folders;
  ScanFlags scan;
  double least_alpha = 0.5;
  std::string histogram;
  CalibrationFiles files;
};

void calibrate_ambient(const CalibrateAmbientFlags& flags, Output& output) {
  CalibrationFiles files = flags.files;
  ScanAverage scans;
  for_each_scan(flags.folders, flags.scan, files, false, output,
                [&](const Scan& scan, const std::string& folder) {
                  require_ambient_measurable(scan, folder);
                  scans.add(scan, folder);
                });
  std::optional<Response> response;
  if (files.scanner && fs::exists(*files.scanner)) {
    const auto measured = read_photometric_calibration(*files.scanner).response;
    if (measured) response = measured->response;
  }
  const auto& [estimate, counted, least_alpha] =
      slipstream::calibrate_ambient(scans, flags.least_alpha, response);
  if (response) output.say("by the response in {}", *files.scanner);
  output.say(
      "ambient light {:.3f} grey levels (mode); median {:.3f}, mean {:.3f}, variance {:.3g}, "
      "over {} pixels with alpha of {} and more",
      estimate.mode, estimate.median, estimate.mean, estimate.variance, estimate.pixels,
      flags.least_alpha);
  output.say(
      "with beta_p = {} frames are off zero where alpha is above {:.4g}; for alpha of 0.15 "
      "and more beta_p must be above {:.4g}",
      scans.sequence().light.beta_p, least_alpha, least_beta_p(0.15, estimate.mode));
  output.document = {{"ambient", estimate.mode},  {"median", estimate.median},
                     {"mean", estimate.mean},     {"variance", estimate.variance},
                     {"pixels", estimate.pixels}, {"least_reliable_alpha", least_alpha}};
  if (!flags.histogram.empty()) {
    write_plot(flags.histogram, bar_plot("Ambient light of the pixels", "grey levels", counted));
    output.document["histogram"] = flags.histogram;
  }
  write_calibration(files, {.ambient = estimate.mode}, output);
}

}  // namespace

void add_calibrate_ambient(CLI::App& calibrate, Command& chosen) {
  const auto [command, flags] =
      add_command(calibrate, chosen, calibrate_ambient, "ambient",
                  "the ambient light, from scans of a bright surface with many steps");
  command
      .add_file("folders", flags.folders,
                "scan folders or recordings of one unmoved scene, pmp; averaged")
      ->required();
  command.add("--least-reflectivity", flags.least_alpha, "of the pixels that count, 0 to 1");
  command.add_output("--histogram", flags.histogram, "of the pixels' ambient light: .png");
  add_calibration_files(command.app, flags.files);
  add_scan_flags(command.app, flags.scan);
  command.app.footer("Example:\n  slipstream calibrate ambient scan_1 scan_2 -o scanner.yaml");
}

}  // namespace slipstream::app
