#include "app/scan_input.h"

#include <string_view>
#include <variant>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/scanner_file.h"

namespace slipstream::app {
namespace fs = std::filesystem;

void add_scan_input_flags(CLI::App& subcommand, ScanInputFlags& flags) {
  subcommand.add_option("--scanner", flags.scanner, "scanner file; where not that of scan.yaml");
  subcommand.add_option("--ambient", flags.photometry.ambient,
                        "ambient light, grey levels of 255, where not that of the scanner file");
  subcommand.add_option("--noise-variance", flags.photometry.noise_variance,
                        "sigma_w^2, grey levels^2 of 255, where not that of the scanner file");
  subcommand
      .add_option(
          "--gamma", flags.gamma,
          "the response the phase is corrected for: scanner (as its file says, if it does), "
          "blind (from the frames), none, or a number")
      ->capture_default_str();
  subcommand.add_option("--bits", flags.bits, "of the camera, where 16-bit files hold fewer");
  add_scan_flags(subcommand, flags.scan);
}

ScanDescription describe(const fs::path& folder, const ScanInputFlags& flags) {
  if (!fs::is_directory(folder)) {
    throw Error(fmt::format("{}: no such folder; a folder of frames is wanted", folder.string()));
  }
  ScanDescription scan;
  if (fs::exists(folder / "scan.yaml")) {
    scan = read_scan_description(folder / "scan.yaml");
  } else if (!flags.scan.strategy) {
    throw Error(fmt::format("{}: no scan.yaml in it; say what the pictures are with --strategy",
                            folder.string()));
  } else {
    scan.frames = images_in_folder(folder);
  }
  scan.strategy = strategy_from(flags.scan, scan.strategy);
  scan.axis = axis_from(flags.scan, scan.axis);
  scan.light = light_from(flags.scan, scan.light);
  scan.projector = projector_from(flags.scan, scan.projector);
  scan.bits = flags.bits.value_or(scan.bits);
  if (scan.bits != 0 && (scan.bits < 8 || scan.bits > 16)) {
    throw Error(fmt::format("--bits {} is out of range; 8 to 16", scan.bits));
  }
  if (flags.scanner) scan.scanner = *flags.scanner;
  if (!scan.scanner) {
    throw Error(fmt::format("{}: no scanner; name its file with --scanner or in scan.yaml",
                            folder.string()));
  }
  const int wanted = frame_count(scan.strategy);
  if (static_cast<int>(scan.frames.size()) != wanted) {
    throw Error(fmt::format("{}: {} frames, but {} with these steps takes {}", folder.string(),
                            scan.frames.size(), name_of(scan.strategy), wanted));
  }
  return scan;
}

Scanner completed(Scanner scanner, const std::string& file, Size camera, Size projector) {
  const auto complete = [&](Size& known, Size said, std::string_view device, std::string_view by) {
    if (known.width == 0 || known.height == 0) known = said;
    if (said != Size{} && known != said) {
      throw Error(fmt::format("{}: its {} has {}, but {} {}; both must agree", file, device,
                              text_of(known), by, text_of(said)));
    }
  };
  complete(scanner.camera.size, camera, "camera", "the frames are");
  complete(scanner.projector.size, projector, "projector", "the patterns are for");
  if (scanner.projector.size == Size{}) {
    throw Error(fmt::format("{}: says no projector size; give it with --projector", file));
  }
  try {
    require_valid(scanner);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", file, error.what()));
  }
  return scanner;
}

Scanner scanner_for(const ScanDescription& scan, Size camera) {
  return completed(read_scanner(*scan.scanner), scan.scanner->string(), camera, scan.projector);
}

void require_known_light(const Strategy& strategy, const PhotometricCalibration& known,
                         const std::string& file) {
  const auto* pcmp = std::get_if<PhaseChannelMultiplexing>(&strategy);
  if (pcmp != nullptr && pcmp->steps == 3 && !known.ambient) {
    throw Error(
        fmt::format("{}: no ambient light in it, which pcmp of 3 frames needs; measure it "
                    "with slipstream calibrate ambient, or give --ambient",
                    file));
  }
}

PhotometricCalibration photometry_for(const ScanDescription& scan, const ScanInputFlags& flags) {
  PhotometricCalibration known = read_photometric_calibration(*scan.scanner);
  if (flags.photometry.ambient) known.ambient = flags.photometry.ambient;
  if (flags.photometry.noise_variance) known.noise_variance = flags.photometry.noise_variance;
  require_known_light(scan.strategy, known, scan.scanner->string());
  return known;
}

ReconstructSettings settings_for(ReconstructSettings settings, const ScanDescription& scan,
                                 const GammaChoice& gamma,
                                 const PhotometricCalibration& photometry) {
  settings.phase_corrections = gamma.corrections;
  settings.cue.light = scan.light;
  settings.cue.ambient = photometry.ambient.value_or(settings.cue.ambient);
  settings.cue.noise_variance = photometry.noise_variance.value_or(settings.cue.noise_variance);
  return settings;
}

}  // namespace slipstream::app
