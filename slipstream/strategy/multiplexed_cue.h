#pragma once

#include "slipstream/strategy/phase_channel_multiplexing.h"

namespace slipstream {

/// What the frames of PCMP say about one pixel; grey levels of an 8-bit device.
struct MultiplexedPixel {
  double modulation = 0;     ///< B_1^c, (1.4)
  double wrapped_phase = 0;  ///< phi_h, rad, [0, 2 pi)
  double cue = 0;            ///< N = 3: A^c (1.3); N = 4: B_cos^c (3.70); N >= 5: C_2,N (3.86)
  double cue_sine = 0;       ///< N >= 5: S_2,N (3.85)
};

/// What the cue says about where a pixel is: Liu 2010, Eqs. (3.58), (3.74), (3.88) solved for the
/// projector coordinate, and the likelihood of any coordinate from all channels of the pixel.
class MultiplexedCue {
 public:
  MultiplexedCue(const PhaseChannelMultiplexing& strategy, const CueSettings& settings);

  /// Whether the modulation stands out of the noise by four standard deviations, and is not below
  /// the least that the settings ask for.
  [[nodiscard]] bool lit(const MultiplexedPixel& pixel) const;

  /// phi_u / (2 pi), in [0, 1].
  [[nodiscard]] double coordinate(const MultiplexedPixel& pixel) const;

  /// How far the cue lies from y, in periods of the high frequency, at most 0.5.
  [[nodiscard]] double doubt(const MultiplexedPixel& pixel, double y) const;

  /// Minus twice the logarithm of the likelihood of y, whatever the reflectivity, up to a constant
  /// of the pixel. Every channel counts by its noise, (3.14) and (3.27).
  [[nodiscard]] double cost(const MultiplexedPixel& pixel, double y) const;

  /// What the cue of 3 steps adds to the mean at y, grey levels; 0 for other steps.
  [[nodiscard]] double shade(const MultiplexedPixel& pixel, double y) const;

  /// Fringe order by the published rule: for N = 3 and 4 held to [0, f_h - 1].
  [[nodiscard]] int published_order(const MultiplexedPixel& pixel) const;

  /// The published rule with the cue of N >= 5 taken for the circle it is: the order is brought
  /// into the field of a projector `length` pixels long.
  [[nodiscard]] int nearest_order(const MultiplexedPixel& pixel, int length) const;

  /// The likeliest order among those near the field of a projector `length` pixels long.
  [[nodiscard]] int likeliest_order(const MultiplexedPixel& pixel, int length) const;

  /// In the field or a tenth of a period past its ends, so that noise there does not carry a pixel
  /// to another period.
  [[nodiscard]] bool near_field(double y, int length) const;

 private:
  PhaseChannelMultiplexing strategy_;
  CueSettings settings_;
  double f_h_, c1_, c2_;
};

}  // namespace slipstream
