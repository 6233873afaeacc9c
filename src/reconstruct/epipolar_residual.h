#pragma once

#include <vector>

#include "slipstream/cloud.h"
#include "slipstream/scanner.h"

// The remainder of a calibration, measured by a scan along both axes.
namespace slipstream {

/// How well a residual map predicts parts of the picture that it was not fitted to.
struct EpipolarScore {
  int degree = 0;        ///< of its polynomials; 0: no map
  double deviation = 0;  ///< of the held-out blocks' median distances, projector pixels
};

/// A residual map of the camera by a scan's distances from the epipolar lines.
struct EpipolarResidual {
  Scanner scanner;                      ///< with the map
  int degree = 0;                       ///< of the map
  std::vector<EpipolarScore> scores{};  ///< of the maps tried, first without one
  int blocks = 0;                       ///< that were compared
  Image<float> before{}, after{};       ///< median distance of each block, or NaN
};

/// Fits a residual map to the `distances` from the epipolar lines, projector pixels, that
/// check_epipolar found for a cloud. Divides the picture into blocks, fits maps to every other
/// block and tries them on the rest; the lowest degree that is about as good as the best is fitted
/// to all. Corrects only the part across the epipolar lines, and takes it for the camera's. Throws
/// Error if too few blocks have points, or if no map predicts the held-out blocks clearly better
/// than none.
EpipolarResidual epipolar_residual(const Scanner& scanner, const Cloud& cloud,
                                   const Image<float>& distances);

}  // namespace slipstream
