#pragma once

#include <cstddef>

#include "slipstream/cloud/cloud.h"
#include "slipstream/codes/sequence.h"
#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream {

/// How a cloud differs from the truth: from the nearest of the surfaces that a pixel and its eight
/// neighbours see, since a lens mixes those.
struct CloudErrors {
  std::size_t points = 0;     ///< in the cloud
  double completeness = 0;    ///< share of the pixels with a lit surface that have one
  double rms = 0;             ///< of depth, mm, flying points left out
  double normalised_rms = 0;  ///< of depth errors over their own sigma, of those within 5
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

/// Takes and reconstructs a scan by each sequence with the world's calibrated scanner, all in the
/// same time: of twice as many frames each has half the exposure, twice the gain, and bodies, whose
/// `motion` is that of the sequence of fewest frames, move half as far. Throws Error as take_scan
/// and Engine.
std::vector<ComparedSequence> compare(const VirtualWorld& world,
                                      const std::vector<Sequence>& sequences,
                                      const ReconstructSettings& settings = {});

}  // namespace slipstream
