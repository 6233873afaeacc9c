#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/manifest.h"
#include "app/reconstruct_flags.h"
#include "slipstream/scan_job.h"

namespace slipstream::app {

/// One scan's results, ready to print.
struct ReconstructedScan {
  ScanName name;
  std::string failure;  ///< reason if it failed, or empty
  Output held{false};   ///< its lines, held until its turn
  ScanOutput output = ScanOutput::points;
  ScanResult result;
  std::vector<std::string> warnings;        ///< from reading the frames
  ResultFiles files;                        ///< files written
  double median_depth = 0;                  ///< mm; 0 if unknown
  std::optional<double> rms, median_sigma;  ///< mm
  std::optional<PredictedRms> predicted{};
  double read = 0, written = 0;  ///< time taken, s
  bool done_before = false;      ///< done by an earlier run; prints nothing else
  nlohmann::json entry;          ///< its manifest entry
};

/// A scan or a map that was read, and its results so far.
struct LoadedScan {
  CheckedJob job;             ///< of a map only the setup and the check
  Image<double> coordinates;  ///< of a map, 0 to 1
  Image<float> modulation;    ///< of a map, if given
  ReconstructedScan scan;
};

/// Reads and checks a scan, or a map. Does nothing if `before` lists the scan as done. An invalid
/// scan, or one of several that cannot be read, is reported as its result's failure.
LoadedScan loaded_scan(const ScanName& name, const ReconstructFlags& flags, const Manifest* before,
                       OpenedRecording& opened, const Output& output);

/// Its part of the JSON document.
nlohmann::json document_of(const ReconstructedScan& scan);

/// Its line of the manifest.
std::string line_of(const ReconstructedScan& scan);

/// "predicted: 0.44 mm from noise, 0.47 mm with edges", and whether edges dominate.
std::string text_of(const PredictedRms& predicted);

/// Prints its lines.
void tell(const ReconstructedScan& scan, Output& output);

}  // namespace slipstream::app
