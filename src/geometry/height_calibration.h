#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "slipstream/image.h"

namespace slipstream {

/// Height from a pixel's phase, without a calibrated projector: at a phase d above the reference
/// plane's, 1 / height = slope / d + bend. Exact for lenses without distortion, for any poses of
/// camera, projector and plane. NaN for an uncalibrated pixel.
struct HeightCurve {
  static constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  float reference = nan;              ///< the phase on the reference plane, any unit
  float slope = nan;                  ///< phase per mm, at height 0
  float bend = nan;                   ///< per mm
  float lowest = nan, highest = nan;  ///< calibrated range of d, including 0

  /// mm; NaN if d is outside the range by more than a tenth of its length.
  [[nodiscard]] double height(double phase) const;
};

/// Phase map of the reference plane moved to a known height.
struct PlanePhase {
  double height = 0;      ///< mm; 0 for the reference
  Image<double> phase{};  ///< absolute; NaN where it was not measured
};

/// A height calibration and its residuals.
struct HeightFit {
  Image<HeightCurve> curves{};
  std::size_t pixels = 0;     ///< number of calibrated pixels
  std::vector<double> rms{};  ///< error, mm, of the heights of each plane, in the given order
};

/// Fits each pixel by least squares to its planes. Skips pixels with fewer than three planes, with
/// a phase that both rises and falls, or with a fit six times worse than the median pixel's and off
/// by more than a thousandth of the largest height. Throws Error unless there are three or more
/// planes, of one size and at different heights including 0, and at least one pixel is calibrated.
HeightFit fit_heights(const std::vector<PlanePhase>& planes);

/// Height of each pixel, mm, NaN without one. Throws Error if the sizes differ.
Image<float> heights(const Image<HeightCurve>& curves, const Image<double>& phase);

/// Throws Error if no pixel is calibrated, or one has values that fit_heights cannot return.
void require_valid(const Image<HeightCurve>& curves);

}  // namespace slipstream
