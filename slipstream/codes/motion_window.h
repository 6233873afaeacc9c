#pragma once

#include "slipstream/codes/layout.h"

namespace slipstream {

/// Of a cycle of N steps, shown over and over, a window of N + `extra` frames from pattern `first`
/// on. Each N frames in a row give the phasor B exp(i phi); what moves between frames adds to it
/// one that turns the other way, and phases then err by a ripple at twice the fringe. Of extra + 1
/// such phasors, one frame after another, a weighted sum is taken in which that ripple has a
/// multiple zero: with x the step from one frame to the next, the characteristic polynomial
/// (Surrel 1996) of the weights is that of N steps times (x - x_0)^extra, x_0 the zero that it has
/// at the conjugate fringe. For N = 4 the weights are binomial (Zhang et al., arXiv 2404.06693).
/// The phase is that in the middle of the window, as if the fringe stood still. Means, cues and
/// further channels in the same frames, as PCMP's, have zeros where the moving phase disturbs them.
///
/// Throws Error unless all that is read of a frame differs from the next one by equal shifts
/// throughout the cycle, and 0 <= extra <= 16, 0 <= first < N.
Layout motion_window(const Layout& cycle, int extra, int first = 0);

/// Amplitude of that ripple, rad, where the phase moves by `speed` rad from frame to frame.
double motion_ripple(const Layout& cycle, int extra, double speed);

}  // namespace slipstream
