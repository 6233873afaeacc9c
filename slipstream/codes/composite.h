#pragma once

#include <string_view>
#include <vector>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/sinusoid.h"

namespace slipstream {

/// A sinusoid as frames show it, alone or with others in the same frames.
struct ShownSinusoid {
  double periods = 1;
  double share = 1;             ///< of the modulation; those of all together at most 1
  double carrier = 0;           ///< periods across the axis
  std::vector<double> angle{};  ///< shift in each frame, rad: cos(2 pi (f y + carrier across) -
                                ///< angle)
  std::vector<bool> shown{};    ///< whether it is in the frame at all
};

/// The same with origin and direction of its shifts: angle - origin, or - angle - origin.
ShownSinusoid turned(ShownSinusoid sinusoid, const Shifts& shifts);

/// Intensity of frame n at y and `across` in [0, 1]: 1/2 and half of each sinusoid.
double composite_intensity(const std::vector<ShownSinusoid>& sinusoids, int n, double y,
                           double across = 0);

/// Weights that take each sinusoid's C and S and the mean out of frames that show them together,
/// those of least noise: the pseudo-inverse of what the frames are made of. Of a sinusoid with a
/// carrier and the next one, its mirror image with a carrier of as many periods less than 0, one
/// band is made: see Band::carrier. Throws Error, beginning with `name`, where they cannot be told
/// apart.
std::vector<Band> fitted_bands(const std::vector<ShownSinusoid>& sinusoids, std::string_view name);

}  // namespace slipstream
