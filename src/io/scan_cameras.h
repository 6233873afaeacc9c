#pragma once

#include "slipstream/scan_files.h"

namespace slipstream {

/// Loads a scan of several cameras before one projector, with the scanner of each; two cameras may
/// be calibrated without the projector. `files`: of the first camera, which names the others. Throws
/// Error as load_scan, and if the cameras' sequences differ.
Scan load_cameras(ScanFiles files, const ScanChanges& changes);

}  // namespace slipstream
