#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <CLI/App.hpp>

#include "app/gamma_choice.h"
#include "app/scan_flags.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/io/photometric_file.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream::app {

/// Flags that say, or say otherwise, what the pictures in a folder are and what took them.
struct ScanInputFlags {
  ScanFlags scan;
  std::optional<std::string> scanner;
  std::optional<int> bits;
  std::string gamma = "scanner";
  PhotometricCalibration photometry;  ///< as far as flags say it
};

/// Adds --scanner, --bits, --gamma, --ambient, --noise-variance and those of add_scan_flags.
void add_scan_input_flags(CLI::App& subcommand, ScanInputFlags& flags);

/// scan.yaml where there is one, else the folder's pictures; flags go before both.
ScanDescription describe(const std::filesystem::path& folder, const ScanInputFlags& flags);

/// The scanner that `file` says, where its sizes are missing completed by what else is known, and
/// checked against it. `projector` may be empty.
Scanner completed(Scanner scanner, const std::string& file, Size camera, Size projector);

/// The scanner of the scan, its sizes completed by what the scan says and checked against it.
Scanner scanner_for(const ScanDescription& scan, Size camera);

/// What the flags say of light and sensor, else the scanner's file. Throws Error where neither says
/// what is needed.
PhotometricCalibration photometry_for(const ScanDescription& scan, const ScanInputFlags& flags);

/// Throws Error where the strategy cannot do without the room's light and that is not known from
/// `file`.
void require_known_light(const Strategy& strategy, const PhotometricCalibration& known,
                         const std::string& file);

/// The settings with the scan's light, its phase corrections and what is known of its noise.
ReconstructSettings settings_for(ReconstructSettings settings, const ScanDescription& scan,
                                 const GammaChoice& gamma,
                                 const PhotometricCalibration& photometry);

}  // namespace slipstream::app
