#pragma once

#include "app/capture.h"

namespace slipstream::app {

/// Throws Error unless the exposures of this source can be chosen.
void require_automatic_possible(const CaptureFlags& flags);

/// Chooses exposures by scans of the scene, within the time of `capture --auto`, and prints them.
/// Throws Error if no exposure shows the patterns, and as taking a scan.
CaptureFlags with_chosen_exposures(const CaptureFlags& flags, Output& output);

}  // namespace slipstream::app
