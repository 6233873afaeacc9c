#pragma once

#include <span>
#include <vector>

namespace slipstream {

/// What the N frames of one sinusoid say about one pixel.
struct PhaseSample {
  double mean = 0;           ///< A^c, grey levels
  double modulation = 0;     ///< B^c, grey levels, >= 0
  double wrapped_phase = 0;  ///< phi, rad, [0, 2 pi)
};

/// Liu 2010, Eqs. (1.3)-(1.7), as printed, in double, for any N >= 3. Holds the N sines and cosines
/// so that they are computed once.
class PhaseEquations {
 public:
  /// Throws Error when `steps` (N) is below 3.
  explicit PhaseEquations(int steps);

  /// `intensities`: I_0^c ... I_{N-1}^c of one pixel, grey levels. Saturated or unlit pixels give
  /// some phase all the same: the modulation tells.
  [[nodiscard]] PhaseSample operator()(std::span<const double> intensities) const;

 private:
  std::vector<double> sines_;
  std::vector<double> cosines_;
};

/// The angle whose sine and cosine are in the ratio of S to C, in [0, 2 pi): the arctangent of
/// Eq. (1.7) with its quadrant. Angles less than 1e-12 rad below 2 pi are 0, so that the rounding
/// of a sum never carries a phase of zero to the other end of the circle; no modulation (both
/// below 1e-12 grey levels) has no angle and gives 0.
double wrapped_angle(double S, double C);

/// The sum of two wrapped phases, in [0, 2 pi), as wrapped_angle has it.
double wrapped_sum(double a, double b);

}  // namespace slipstream
