#pragma once

#include <cstddef>
#include <vector>

#include "slipstream/engine.h"
#include "slipstream/virtual_world.h"

namespace slipstream {

/// Errors of a cloud relative to the nearest surface seen by a pixel and its eight neighbours,
/// since the lens mixes those.
struct CloudErrors {
  std::size_t points = 0;     ///< in the cloud
  double completeness = 0;    ///< share of the pixels with a lit surface that have a point
  double rms = 0;             ///< of depth, mm, without flying points
  double predicted = 0;       ///< the RMS that sigma predicts for these points, mm
  double normalised_rms = 0;  ///< RMS of depth error / sigma, over points within 5 sigma
  double beyond_5 = 0;        ///< share of points with a depth error above 5 sigma
  double flying = 0;          ///< share off every surface by more than 5 sigma and 1 mm
  double wrong_order = 0;     ///< share with a coordinate error of half a period or more
};

/// `coordinate` and `layout`: of the cloud's scan.
CloudErrors cloud_errors(const Cloud& cloud, const Uncertainty& uncertainty,
                         const Image<float>& coordinate, const Layout& layout,
                         const VirtualScan& truth, const VirtualWorld& world);

/// How well a sequence measures a scene.
struct ComparedSequence {
  CloudErrors errors{};
  double repeatability = 0;  ///< of depth from scan to scan, mm; 0 for moving scenes
  double decode_ms = 0;      ///< frames to cloud, the fastest of several
  Cloud cloud{};             ///< of the first scan
};

/// Simulates and reconstructs a scan for each sequence with the world's calibrated scanner, all in
/// the same total time: twice as many frames get half the exposure, twice the gain and half the
/// motion each. The bodies' `motion` is per frame of the shortest sequence. Throws Error as
/// take_scan and Engine.
std::vector<ComparedSequence> compare(const VirtualWorld& world,
                                      const std::vector<Sequence>& sequences,
                                      const ReconstructSettings& settings = {});

}  // namespace slipstream
