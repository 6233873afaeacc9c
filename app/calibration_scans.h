#pragma once

#include <filesystem>

#include "app/scan_flags.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream::app {

/// The scan in a folder as its scan.yaml says, or where there is none its pictures as the flags
/// say; flags go before both. Throws Error where the frames are not as many as the strategy's.
ScanDescription describe_scan(const std::filesystem::path& folder, const ScanFlags& flags);

/// Where to write a calibration: `-o`, into what `--scanner` or the first scan names.
struct CalibrationFiles {
  std::optional<std::string> scanner;
  std::string output;
};

/// Adds --scanner and -o.
void add_calibration_files(CLI::App& command, CalibrationFiles& files);

/// 1 where no frame of a scan is at either end of the grey levels, so that its mean is right.
Image<std::uint8_t> unclipped(const FrameSet& frames);

}  // namespace slipstream::app
