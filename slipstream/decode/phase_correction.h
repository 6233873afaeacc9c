#pragma once

#include <map>
#include <vector>

namespace slipstream {

/// What is added to the wrapped phase that N steps measure, so that the projector's response no
/// longer shows in it: Delta phi of Liu 2010, Eqs. (4.45), (4.56), with its sign turned. It is a
/// function of the measured phase alone and repeats N times around the circle.
struct PhaseCorrection {
  int steps = 0;              ///< N, >= 3
  std::vector<double> added;  ///< rad, at measured phase 2 pi i / (N added.size()); linear between
};

/// One correction for each N that needs one; an N that is not there is left alone.
using PhaseCorrections = std::map<int, PhaseCorrection>;

/// Throws Error unless the correction is for that many steps, N >= 3, and has finite entries.
void require_valid(const PhaseCorrection& correction, int steps);

/// The wrapped phase without the projector's response, rad, [0, 2 pi). `phi` is in [0, 2 pi).
double corrected_phase(const PhaseCorrection& correction, double phi);

}  // namespace slipstream
