#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "slipstream/decode/equations.h"

namespace slipstream {

/// Modulation and phase of 3, 4 or 6 frames from two integers, Liu 2010, Eqs. (2.1)-(2.18):
/// U = sum u_n I_n and V = sum v_n I_n are all that B and phi depend on.
struct ClosedForm {
  int steps;
  std::array<int, 6> u;
  std::array<int, 6> v;
  double divisor;      ///< of the modulation: 3, 2 or 6
  double sine_square;  ///< weight of V^2 under the root: 3 or 1; its root weighs V in the phase

  /// B^c: Eqs. (2.4), (2.7), (2.10).
  [[nodiscard]] double modulation(double U, double V) const {
    return std::sqrt(sine_square * V * V + U * U) / divisor;
  }
  /// phi in [0, 2 pi): Eqs. (2.16)-(2.18).
  [[nodiscard]] double wrapped_phase(double U, double V) const {
    return wrapped_angle(std::sqrt(sine_square) * V, U);
  }
};

/// The closed form for N = 3, 4 or 6; null for any other N, which has none.
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

}  // namespace slipstream
