#pragma once

#include <vector>

#include "slipstream/codes/sequence.h"
#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/simulate/cloud_errors.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream {

/// How well a sequence measures a scene.
struct ComparedSequence {
  CloudErrors errors{};
  double repeatability = 0;  ///< of depth from take to take, mm; 0 for moving scenes
  double decode_ms = 0;      ///< frames to cloud, the fastest of several
  Cloud cloud{};             ///< of the first take
};

/// Takes and reconstructs one scan by each sequence with the world's scanner, as calibrated for
/// response, light and noise, all in the same time: of twice as many frames each is exposed half as
/// long, the camera's gain twice as high, and bodies, whose `motion` is meant for the sequence of
/// the fewest frames, move half as far from one to the next. Throws Error as take_scan and Engine.
std::vector<ComparedSequence> compare(const VirtualWorld& world,
                                      const std::vector<Sequence>& sequences,
                                      const ReconstructSettings& settings = {});

}  // namespace slipstream
