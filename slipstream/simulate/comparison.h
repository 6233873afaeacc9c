#pragma once

#include <cstddef>
#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/codes/sequence.h"
#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream {

/// How a cloud differs from what was really there. Its points are held against the nearest of the
/// surfaces that the pixel and its eight neighbours see, since a lens mixes those.
struct CloudErrors {
  std::size_t points = 0;   ///< in the cloud
  double completeness = 0;  ///< share of the pixels with a lit surface that have one
  double rms = 0;           ///< of depth, mm, flying points left out
  /// Root mean square of depth errors over their own sigma, of those within 5.
  double normalised_rms = 0;
  double beyond_5 = 0;     ///< share of the points whose depth errs by more than 5 of their sigma
  double flying = 0;       ///< share off every surface by more than 5 sigma and 1 mm
  double wrong_order = 0;  ///< share whose projector coordinate errs by half a period and more
};

/// `coordinate` and `layout`: of the scan that the cloud is of.
CloudErrors cloud_errors(const Cloud& cloud, const Uncertainty& uncertainty,
                         const Image<float>& coordinate, const Layout& layout,
                         const VirtualScan& truth, const VirtualWorld& world);

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
