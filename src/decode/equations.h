#pragma once

#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "slipstream/pattern_set.h"

namespace slipstream {

/// Decoded values of one pixel from the N frames of one sinusoid.
struct PhaseSample {
  double mean = 0;           ///< A^c, grey levels
  double modulation = 0;     ///< B^c, grey levels, >= 0
  double wrapped_phase = 0;  ///< phi, rad, [0, 2 pi)
};

/// Liu 2010, Eqs. (1.3)-(1.7), as printed, in double, for N >= 3. Stores N sines and cosines.
class PhaseEquations {
 public:
  /// Throws Error if `steps` (N) is below 3.
  explicit PhaseEquations(int steps);

  /// `intensities`: I_0^c ... I_{N-1}^c of one pixel, grey levels. Saturated or unlit pixels also
  /// give a phase: check the modulation.
  [[nodiscard]] PhaseSample operator()(std::span<const double> intensities) const;

 private:
  std::vector<double> sines_;
  std::vector<double> cosines_;
};

/// The angle of C + i S, [0, 2 pi): the arctangent of Eq. (1.7) with its quadrant. 0 for angles
/// less than 1e-12 rad below 2 pi, so that rounding never moves a phase of zero around the circle,
/// and without modulation (both below 1e-12 grey levels).
double wrapped_angle(double S, double C);

/// The sum of two wrapped phases, in [0, 2 pi), rounded as in wrapped_angle.
inline double wrapped_sum(double a, double b) {
  return wrapped_angle(std::sin(a + b), std::cos(a + b));
}

/// Modulation and phase of 3, 4 or 6 frames from two integers, Liu 2010, Eqs. (2.1)-(2.18): B and
/// phi depend only on U = sum u_n I_n and V = sum v_n I_n.
struct ClosedForm {
  int steps;
  std::array<int, 6> u;
  std::array<int, 6> v;
  double divisor;      ///< of the modulation: 3, 2 or 6
  double sine_square;  ///< weight of V^2 under the root: 3 or 1; V's in the phase is its root

  /// B^c: Eqs. (2.4), (2.7), (2.10).
  [[nodiscard]] double modulation(double U, double V) const {
    return std::sqrt(sine_square * V * V + U * U) / divisor;
  }

  /// phi in [0, 2 pi): Eqs. (2.16)-(2.18).
  [[nodiscard]] double wrapped_phase(double U, double V) const {
    return wrapped_angle(std::sqrt(sine_square) * V, U);
  }
};

/// The closed form for N = 3, 4 or 6; null for any other N.
const ClosedForm* closed_form(int steps);

/// Eqs. (2.5), (2.6), (2.8), (2.9), (2.11), (2.12), of integer or real intensities.
template <class Number>
struct TableIndex {
  Number U = 0;
  Number V = 0;
};

template <class Number, class Pixel>
TableIndex<Number> table_index(const ClosedForm& form, std::span<const Pixel> I) {
  TableIndex<Number> index;
  for (std::size_t n = 0; n < I.size(); ++n) {
    index.U += static_cast<Number>(form.u[n]) * static_cast<Number>(I[n]);
    index.V += static_cast<Number>(form.v[n]) * static_cast<Number>(I[n]);
  }

  return index;
}

/// Reflectivity alpha of a pixel from the modulation B^c (grey levels) of N-step PMP: Liu 2010, Eq.
/// (3.6). For a sinusoid with a share c_1 of the modulation, Eq. (3.59), pass c_1.
constexpr double reflectivity(double modulation, double alpha_p, double share = 1) {
  return 2 * modulation / (alpha_p * share);
}

/// Ambient light beta (grey levels; negative if the camera subtracts an offset) from the mean A^c
/// of N-step PMP and the reflectivity: Eq. (3.5).
constexpr double ambient_light(double mean, double alpha, const PatternLight& light) {
  return (mean - alpha * (light.alpha_p / 2 + light.beta_p)) / (alpha + 1);
}

/// Least beta_p without underflow at that reflectivity: Eq. (3.7); 0 if ambient >= 0.
constexpr double least_beta_p(double alpha, double ambient) {
  return ambient < 0 ? -(1 + 1 / alpha) * ambient : 0;
}

/// Least reflectivity without underflow at that beta_p: Eq. (3.9); 0 if ambient >= 0; may be
/// infinite.
double least_reliable_reflectivity(double beta_p, double ambient);

}  // namespace slipstream
