#pragma once

#include "simulate/accuracy.h"
#include "slipstream/engine.h"
#include "slipstream/virtual_world.h"

namespace slipstream {

/// An acceptance test in the virtual world: exact artefacts, and the clouds of their scans,
/// simulated on demand.
struct Rehearsal {
  Artefacts artefacts;
  CloudOfScan cloud_of;
};

/// Simulates a ball bar of spheres of 0.1 L, 0.35 L apart, in seven positions (the four diagonals
/// and three near the sides of the measured volume), a square plane with sides of 0.5 L in six, and
/// ten scans of one of these that differ only in noise. L: diagonal of the measured volume, the
/// largest cube around the centre of the working volume that both devices fully see. Ignores the
/// scene of `world`. Reconstructs scans with `calibrated`; the world's own scanner excludes
/// calibration errors. Throws Error if the devices see no common volume.
Rehearsal rehearsal(const VirtualWorld& world, const Sequence& sequence, const Scanner& calibrated,
                    const ReconstructSettings& settings = {});

}  // namespace slipstream
