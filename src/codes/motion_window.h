#pragma once

#include "slipstream/layout.h"

namespace slipstream {

/// A window of N + `extra` frames, starting with pattern `first`, of a repeated cycle of N steps.
/// Each N consecutive frames give the phasor B exp(i phi); motion between frames adds one of
/// opposite rotation, a phase ripple at twice the fringe frequency. A weighted sum of the extra + 1
/// successive phasors has a multiple zero for that ripple: with x the step from frame to frame, the
/// characteristic polynomial (Surrel 1996) is that for N steps times (x - x_0)^extra, x_0 its zero
/// at the conjugate fringe. For N = 4 the weights are binomial (Zhang et al., arXiv 2404.06693).
/// The phase is the one at the window's middle, as if the fringe did not move. Means, cues and
/// further channels, as in PCMP, have zeros where the moving phase disturbs them. Throws Error
/// unless all channels shift equally from frame to frame, 0 <= extra <= 16 and 0 <= first < N.
Layout motion_window(const Layout& cycle, int extra, int first = 0);

/// Amplitude of the remaining ripple, rad, if the phase moves by `speed` rad per frame.
double motion_ripple(const Layout& cycle, int extra, double speed);

}  // namespace slipstream
