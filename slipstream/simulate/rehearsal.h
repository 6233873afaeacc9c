#pragma once

#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/simulate/accuracy.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream {

/// An acceptance test in the virtual world: artefacts that are exactly as certified, and the clouds
/// of their scans, taken as they are asked for.
struct Rehearsal {
  Artefacts artefacts;
  CloudOfScan cloud_of;
};

/// With L the diagonal of the measured volume, the largest cube about the middle of the working
/// volume that camera and projector see whole: a ball bar of spheres of 0.1 L, 0.35 L apart, in
/// seven positions (the four diagonals of the cube and three near its sides), a square plane with
/// sides of 0.5 L in six, and ten scans of one of these that differ by their noise alone. The scene
/// of `world` is not asked for. Scans are reconstructed with `calibrated`: the world's scanner,
/// where the error of a calibration is not to be in the figures. Throws Error where the two see no
/// volume in common.
Rehearsal rehearsal(const VirtualWorld& world, const Sequence& sequence, const Scanner& calibrated,
                    const ReconstructSettings& settings = {});

}  // namespace slipstream
