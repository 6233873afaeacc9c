#pragma once

#include "app/manifest.h"
#include "app/reconstructed_scan.h"

namespace slipstream::app {

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

}  // namespace slipstream::app
