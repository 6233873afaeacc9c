#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/calibration_files.h"
#include "app/commands.h"
#include "slipstream/base/error.h"
#include "slipstream/response/noise_calibration.h"

namespace slipstream::app {
namespace {

struct CalibrateNoiseFlags {
  std::vector<std::string> folders;
  ScanFlags scan;
  CalibrationFiles files;
};

nlohmann::json json_of(const NoiseMeasurement& measured) {
  return {{"equation", measured.equation},
          {"variance", measured.variance},
          {"standard_error", measured.standard_error},
          {"count", measured.count},
          {"pixels", measured.pixels},
          {"agrees", measured.reason.empty()},
          {"reason", measured.reason}};
}

void calibrate_noise(const CalibrateNoiseFlags& flags, Output& output) {
  CalibrationFiles files = flags.files;
  std::vector<NoiseScan> scans;
  for_each_scan(flags.folders, flags.scan, files, false, output,
                [&](const Scan& scan, const std::string&) { scans.emplace_back(scan); });
  const std::vector<NoiseMeasurement> all = slipstream::calibrate_noise(scans);
  output.document["measurements"] = nlohmann::json::array();
  for (const NoiseMeasurement& measured : all) {
    output.say("sigma_w^2 {:.4f}, standard error {:.2g}: Eq. ({}), {}, {} times{}{}",
               measured.variance, measured.standard_error, measured.equation, measured.method,
               measured.count, measured.reason.empty() ? "" : "; ", measured.reason);
    output.list("measurements").push_back(json_of(measured));
  }
  const NoiseMeasurement& trusted = all.front();
  if (mistakes_gamma_for_noise(trusted)) {
    output.warn(
        fmt::format("Eq. ({}) alone counts a response that is not linear as noise; two "
                    "scans alike would tell",
                    trusted.equation));
  }
  const NoiseLine line = noise_line(scans).value_or(NoiseLine{.at_half = trusted.variance});
  if (line.gain > 0) {
    output.say(
        "it grows by {:.4f} with each grey level, standard error {:.2g}: {:.4f} at half of "
        "full scale",
        line.gain, line.gain_error, line.at_half);
  }
  output.document["noise_variance"] = line.at_half;
  output.document["noise_gain"] = line.gain;
  if (!files.output.empty() && !(trusted.variance > 0)) {
    throw Error("the scans show no noise; nothing was written");
  }
  if (trusted.variance > 0) {
    write_calibration(files, {.noise_variance = line.at_half, .noise_gain = line.gain}, output);
  }
}

}  // namespace

void add_calibrate_noise(CLI::App& calibrate, Command& chosen) {
  const auto [command, flags] =
      add_command(calibrate, chosen, calibrate_noise, "noise",
                  "the variance of the frames' noise, by all measurements that the scans allow");
  command.add_file("folders", flags.folders, "scan folders or recordings of one unmoved scene")
      ->required();
  add_calibration_files(command.app, flags.files);
  add_scan_flags(command.app, flags.scan);
  command.app.footer("Example:\n  slipstream calibrate noise scan_1 scan_2 scan_3 -o scanner.yaml");
}

}  // namespace slipstream::app
