#pragma once

#include "app/reconstruct_flags.h"

namespace slipstream::app {

/// Reconstructs `scans` and prints each result. Throws Error for contradictory flags.
void reconstruct_scans(ReconstructFlags flags, Output& output);

}  // namespace slipstream::app
