#include "app/scan_input.h"

#include <fmt/format.h>

#include "app/flag_group.h"
#include "slipstream/base/error.h"
#include "slipstream/io/saved_scan.h"

namespace slipstream::app {

void add_scan_input_flags(CLI::App& subcommand, ScanInputFlags& flags) {
  const FlagGroup options{subcommand};
  options.add_file("--scanner", flags.scanner, "scanner file; where not that of the scan");
  options.add("--ambient", flags.photometry.ambient,
              "ambient light, grey levels of 255, where not that of the scanner file");
  options.add("--noise-variance", flags.photometry.noise_variance,
              "sigma_w^2, grey levels^2 of 255, where not that of the scanner file");
  options.add("--gamma", flags.gamma,
              "the response the phase is corrected for: scanner (as its file says, if it does), "
              "blind (from the frames), none, or a number");
  options.add("--camera-bits", flags.bits, "of the camera, where 16-bit files hold fewer");
  add_scan_flags(subcommand, flags.scan);
}

void add_point_flags(CLI::App& subcommand, ReconstructSettings& settings) {
  const FlagGroup group{subcommand, "Which pixels become points"};
  group.add("--min-modulation", settings.minimum_modulation,
            "least modulation, grey levels of 255 whatever the camera's bits");
  subcommand
      .add_flag_callback(
          "--keep-saturated", [&settings] { settings.drop_saturated = false; },
          "keep pixels with a saturated frame")
      ->group(group.name);
  group.add("--nearest", settings.nearest,
            "least depth, mm; half of the nearest calibrated where not given");
  group.add("--farthest", settings.farthest,
            "largest depth, mm; twice the farthest calibrated where not given");
}

std::shared_ptr<const RecordingReader> OpenedRecording::at(const std::string& path) {
  const std::lock_guard lock(mutex_);
  if (reader_ != nullptr && path == path_) return reader_;
  reader_ = is_recording(path) ? std::make_shared<const RecordingReader>(path) : nullptr;
  path_ = path;
  return reader_;
}

ScanChanges changes_of(const ScanInputFlags& flags) {
  ScanChanges changes = scan_changes_from(flags.scan);
  changes.bits = flags.bits;
  changes.recording = flags.recording;
  changes.window = flags.window;
  if (flags.scanner) changes.scanner = *flags.scanner;
  return changes;
}

Scan load_checkable(const std::string& path, const ScanInputFlags& flags, bool all_cameras,
                    Output& output) {
  const ScanChanges changes = changes_of(flags);
  Scan scan = all_cameras ? load_scan(path, changes) : load_scan(scan_files_in(path, changes));
  if (scan.scanner) {
    PhotometricCalibration& known = scan.scanner->photometry;
    if (flags.photometry.ambient) known.ambient = flags.photometry.ambient;
    if (flags.photometry.noise_variance) known.noise_variance = flags.photometry.noise_variance;
  }
  for (const std::string& warning : scan.warnings) output.warn(warning);
  for (const Scan& further : scan.further_cameras) {
    for (const std::string& warning : further.warnings) output.warn(warning);
  }
  return scan;
}

Scan load(const std::string& path, const ScanInputFlags& flags, bool all_cameras, Output& output) {
  Scan scan = load_checkable(path, flags, all_cameras, output);
  if (scan.scanner) return scan;
  throw Error(fmt::format(
      "{}: no scanner is known for it; name its file with --scanner or in scan.yaml", path));
}

nlohmann::json json_of(const GammaChoice& choice) {
  nlohmann::json document{{"source", choice.source}};
  if (choice.gamma) document["gamma"] = *choice.gamma;
  if (choice.blind) {
    document["standard_error"] = choice.blind->standard_error;
    document["pixels"] = choice.blind->pixels;
    if (!choice.blind->accepted()) document["refused"] = reason_of(choice.blind->refusal);
  }
  return document;
}

}  // namespace slipstream::app
