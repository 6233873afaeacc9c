#include "app/scan_input.h"

#include <fmt/format.h>

#include "app/flag_group.h"
#include "slipstream/error/error.h"
#include "slipstream/io/saved_scan.h"

namespace slipstream::app {
namespace fs = std::filesystem;

void add_scan_input_flags(CLI::App& subcommand, ScanInputFlags& flags) {
  const FlagGroup options{subcommand};
  options.add("--scanner", flags.scanner, "scanner file; where not that of scan.yaml");
  options.add("--ambient", flags.photometry.ambient,
              "ambient light, grey levels of 255, where not that of the scanner file");
  options.add("--noise-variance", flags.photometry.noise_variance,
              "sigma_w^2, grey levels^2 of 255, where not that of the scanner file");
  options.add("--gamma", flags.gamma,
              "the response the phase is corrected for: scanner (as its file says, if it does), "
              "blind (from the frames), none, or a number");
  options.add("--bits", flags.bits, "of the camera, where 16-bit files hold fewer");
  add_scan_flags(subcommand, flags.scan);
}

void add_point_flags(CLI::App& subcommand, ReconstructSettings& settings) {
  const FlagGroup group{subcommand, "Which pixels become points"};
  group.add("--min-modulation", settings.minimum_modulation,
            "least modulation, grey levels of the frames; 15 of 255 where not given");
  subcommand
      .add_flag_callback(
          "--keep-saturated", [&settings] { settings.drop_saturated = false; },
          "keep pixels with a saturated frame")
      ->group(group.name);
  group.add("--nearest", settings.nearest, "least depth, mm");
  group.add("--farthest", settings.farthest, "largest depth, mm")->default_str("");
}

namespace {

/// The files of a scan, as scan.yaml and the flags say it.
ScanFiles files_from(const fs::path& folder, const ScanInputFlags& flags) {
  ScanFiles files = describe(folder, flags.scan);
  files.bits = flags.bits.value_or(files.bits);
  if (files.bits != 0 && (files.bits < 8 || files.bits > 16)) {
    throw Error(fmt::format("--bits {} is out of range; 8 to 16", files.bits));
  }
  if (flags.scanner) files.scanner = *flags.scanner;
  return files;
}

Scan load(const ScanFiles& files, const ScanInputFlags& flags, bool all_cameras, Output& output) {
  Scan scan = load_scan(files);
  if (all_cameras && files.second_camera) {
    add_camera(scan, describe(*files.second_camera, flags.scan));
  }
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

GammaChoice choose_response_of_camera(Scan& scan, const std::string& how) {
  std::optional<MeasuredResponse> known;
  if (scan.scanner) known = scan.scanner->photometry.response;
  GammaChoice choice = choose_gamma(how, known, scan.sequence.strategy.layout(), scan.frames);
  if (scan.scanner) scan.scanner->photometry.response = choice.response;
  return choice;
}

}  // namespace

Scan load(const fs::path& folder, const ScanInputFlags& flags, bool all_cameras, Output& output) {
  const ScanFiles files = files_from(folder, flags);
  if (!files.scanner) {
    throw Error(fmt::format("{}: no scanner; name its file with --scanner or in scan.yaml",
                            folder.string()));
  }
  return load(files, flags, all_cameras, output);
}

Scan load_checkable(const fs::path& folder, const ScanInputFlags& flags, bool all_cameras,
                    Output& output) {
  return load(files_from(folder, flags), flags, all_cameras, output);
}

GammaChoice choose_response(Scan& scan, const ScanInputFlags& flags) {
  for (Scan& further : scan.further_cameras) choose_response_of_camera(further, flags.gamma);
  return choose_response_of_camera(scan, flags.gamma);
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
