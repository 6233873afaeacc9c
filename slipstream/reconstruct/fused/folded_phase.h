#pragma once

#include <vector>

#include "slipstream/decode/phase_correction.h"

namespace slipstream {

/// The corrected phase of 3, 4 or 6 frames straight from U and V, so that a correction takes the
/// place of the arctangent's polynomial instead of following it.
///
/// A response's harmonics are the same in each of the N periods and on both sides of a crest.
/// Reflections therefore fold the circle to the phases from 0 to T, T = pi/3 for N = 3 and 6 and
/// pi/4 for N = 4, where V/U (folded) goes from 0 to 1. There the corrected phase is a
/// polynomial in x = (U - (2 + b) V) / (U + b V), which goes from 1 to -1. Any b > -1 will do; it
/// is chosen so that the fewest terms are needed: where the correction bends most, near one end, x
/// runs fastest. For gamma 2.2 and N = 3 this takes degree 11 where powers of the angle or its
/// tangent take 20 and more.
struct FoldedPhase {
  static constexpr int largest_degree = 24;

  float b = 0;
  std::vector<float> coefficients{};  ///< of the phase in turns, from that of the highest power on

  [[nodiscard]] bool empty() const { return coefficients.empty(); }
};

/// To 8e-7 rad. Empty for other N, where the correction is no odd function of the phase or leads
/// out of [0, T], and where it bends too much.
FoldedPhase folded_phase(const PhaseCorrection& correction);

}  // namespace slipstream
