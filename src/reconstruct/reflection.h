#pragma once

#include <complex>

#include "slipstream/engine.h"

// Light that other surfaces reflect onto a point, or that spreads within its surface.
namespace slipstream {

/// Whether patterns show such light: it disturbs a band of a quarter to a sixteenth of the
/// measuring band's periods far more than the measuring band.
bool shows_reflection(const Layout& layout);

/// How such light disturbs the coarsest band of each point: the difference of its phasor from the
/// one that the measuring band predicts, shares of the modulation; NaN without a point.
struct Disturbance {
  Image<std::complex<float>> share;
  double blur = 0;     ///< share that a lens's blur may explain, in phase
  double finer = 1;    ///< periods of the measuring band over those of the coarsest
  Image<float> sigma;  ///< standard deviation of the measuring band's phase by noise, rad
};

/// Requires shows_reflection. `frames`: those of cloud and maps.
Disturbance disturbance_of(const FrameViews& frames, const Cloud& cloud, const Maps& maps,
                           const EngineSetup& setup);

/// Error of each point's coordinate that the disturbance predicts, in standard deviations by noise;
/// NaN without a point. From the mean over the pixels up to `half` away; with `same_surface` over
/// those alone that lie as deep as the point to within 2 %.
Image<float> predicted_errors(const Disturbance& disturbance, const Cloud& cloud, int half,
                              bool same_surface);

}  // namespace slipstream
