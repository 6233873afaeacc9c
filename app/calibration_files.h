#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "app/output.h"
#include "app/scan_flags.h"
#include "slipstream/geometry/scan.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/io/plot.h"
#include "slipstream/response/measurement.h"

namespace slipstream::app {

/// Where to write a calibration: `-o`, into what `--scanner` or the first scan names.
struct CalibrationFiles {
  std::optional<std::string> scanner;
  std::string output;
};

/// Adds --scanner and -o.
void add_calibration_files(CLI::App& command, CalibrationFiles& files);

/// Calls `take` with the frames of each folder and what they show, as scan.yaml and the flags say
/// it, once they are checked: it warns of what is doubtful and throws Error for what is wrong.
/// Where `files` names no scanner, the first scan's is the one to add to. `of_gamma`: the scans are
/// there to measure the response, which nothing is then corrected for: that it shows is no news.
void for_each_scan(const std::vector<std::string>& folders, const ScanFlags& flags,
                   CalibrationFiles& files, bool of_gamma, Output& output,
                   const std::function<void(const Scan& scan, const std::string& folder)>& take);

/// Writes what was found where it is asked for, and says so.
void write_calibration(const CalibrationFiles& files, const PhotometricCalibration& found,
                       Output& output);

/// How many pixels have which value.
BarPlot bar_plot(const std::string& title, const std::string& unit, const Histogram& counted);

}  // namespace slipstream::app
