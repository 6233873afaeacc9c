#pragma once

#include "app/manifest.h"
#include "app/reconstruct_flags.h"
#include "slipstream/reconstruct/epipolar.h"

namespace slipstream::app {

/// One scan's results, ready to print.
struct ReconstructedScan {
  ScanName name;
  std::string failure;  ///< reason if it failed, or empty
  Output words{false};  ///< its lines, held until its turn

  Cloud cloud;
  ValidityCounts counts{};
  Maps maps;  ///< if requested
  Wanted wanted = Wanted::points;
  std::optional<Uncertainty> uncertainty;
  std::optional<EpipolarCheck> epipolar;  ///< both axes only

  std::string backend;
  std::vector<std::string> warnings;
  SoundScan sound;
  ResultFiles files;  ///< files written

  std::optional<double> rms, predicted, median_sigma;  ///< mm
  double least_modulation = 0;  ///< minimum modulation of a point, grey levels of 255
  double read = 0, tables = 0, computed = 0, written = 0;  ///< s
  bool done_before = false;  ///< done by an earlier run; prints nothing else
  nlohmann::json entry;      ///< its manifest entry
};

/// A scan or a map that was read, and its results so far.
struct LoadedScan {
  Scan scan;
  Image<double> coordinates;  ///< of a map, 0 to 1
  Image<float> modulation;    ///< of a map, if given
  ReconstructedScan result;
};

/// Reads and checks a scan, or a map. Does nothing if `before` lists the scan as done. An invalid
/// scan, or one of several that cannot be read, is reported as its result's failure.
LoadedScan loaded_scan(const ScanName& name, const ReconstructFlags& flags, const Manifest* before,
                       OpenedRecording& opened, const Output& output);

/// Its part of the JSON document.
nlohmann::json document_of(const ReconstructedScan& scan);

/// Its line of the manifest.
std::string line_of(const ReconstructedScan& scan);

/// Prints its lines.
void tell(const ReconstructedScan& scan, Output& output);

}  // namespace slipstream::app
