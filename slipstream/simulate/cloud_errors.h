#pragma once

#include <cstddef>

#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/uncertainty.h"
#include "slipstream/codes/layout.h"
#include "slipstream/simulate/virtual_scanner.h"

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
                         const VirtualScan& truth, const Scanner& scanner, const Scene& scene);

/// Standard deviation of depth from take to take, mm: by the median difference of two clouds of one
/// unmoved scene. 0 where they have no point in common.
double repeatability(const Cloud& first, const Cloud& second);

}  // namespace slipstream
