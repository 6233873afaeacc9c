#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "slipstream/base/image.h"

namespace slipstream {

/// Height by the phase of a pixel without a calibrated projector: where the phase is d more than on
/// a reference plane, 1 / height = slope / d + bend. Exact for lenses without distortion, whatever
/// the poses of camera, projector and plane. NaN where the pixel is not calibrated.
struct HeightCurve {
  static constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  float reference = nan;              ///< the phase on the plane, of any unit
  float slope = nan;                  ///< phase per mm, at height 0
  float bend = nan;                   ///< per mm
  float lowest = nan, highest = nan;  ///< d that was calibrated, 0 among it

  /// mm; NaN where d is not of the range or a tenth of its length beyond.
  [[nodiscard]] double height(double phase) const;
};

/// What the pixels saw of the reference plane moved to a known height.
struct PlanePhase {
  double height = 0;      ///< mm; 0: where it is the reference
  Image<double> phase{};  ///< absolute; NaN where it was not measured
};

/// A calibration, and how its planes fit it.
struct HeightFit {
  Image<HeightCurve> curves{};
  std::size_t pixels = 0;     ///< that are calibrated
  std::vector<double> rms{};  ///< error, mm, of the heights of each plane, in the order given
};

/// Fits each pixel by least squares to its planes, but for pixels that see fewer than three, whose
/// phase both rises and falls, or whose planes fit six times worse than those of half of the
/// others, and by more than a thousandth of the largest height. Throws Error unless there are three
/// planes or more, of one size and at different heights, 0 among them, and a pixel is calibrated.
HeightFit fit_heights(const std::vector<PlanePhase>& planes);

/// Of each pixel, mm, NaN where there is none. Throws Error where the sizes differ.
Image<float> heights(const Image<HeightCurve>& curves, const Image<double>& phase);

/// Throws Error where no pixel is calibrated, or one has numbers that fit_heights does not give.
void require_valid(const Image<HeightCurve>& curves);

}  // namespace slipstream
