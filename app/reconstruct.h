#pragma once

#include "app/reconstruct_flags.h"

namespace slipstream::app {

/// Reconstructs `scans` and prints each result. Throws Error for contradictory flags.
void reconstruct_scans(ReconstructFlags flags, Output& output);

/// Adds `reconstruct`, which turns scans into clouds and maps.
void add_reconstruct(const Commands& program);

}  // namespace slipstream::app
