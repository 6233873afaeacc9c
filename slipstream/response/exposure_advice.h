#pragma once

#include <vector>

#include "slipstream/codes/sequence.h"
#include "slipstream/frames/frame_set.h"

namespace slipstream {

/// What a pixel needs to become a good point, grey levels of 255.
struct ExposureNeeds {
  double least_modulation = 15;  ///< above 0, up to 127
  double noise_variance = 1.6;   ///< sigma_w^2, >= 0
};

/// What one or several exposures, merged, measure of the lit pixels.
struct ExposureChoice {
  std::vector<double> exposures{};  ///< in the unit of those taken
  double measured = 0;   ///< share that is not saturated and has the least modulation, 0 to 1
  double saturated = 0;  ///< share that the shortest of them saturates
  double too_dark = 0;   ///< share below the least modulation
  /// Of the projector coordinate by Eq. (3.40) or (3.63), the median of what is measured, fields; 0
  /// where nothing is.
  double sigma = 0;
};

struct ExposureAdvice {
  double lit = 0;  ///< share of all pixels in which the patterns show, saturated ones among them
  /// Share of the lit pixels that even the shortest exposure taken saturates: how bright they are
  /// is not known, and no choice counts them as measured.
  double unknown = 0;
  std::vector<ExposureChoice> taken{};  ///< each exposure alone, then all where there are several
  std::vector<ExposureChoice> proposed{};  ///< the best one, two and three
  /// Of the proposed: the first to which one more exposure would add less than 2 % of the lit
  /// pixels.
  std::size_t best = 0;
  /// How bright the patterns would have to be, of the light taken, for the shortest exposure taken
  /// to be the best one; 1 where it is not too long.
  double light = 1;
};

/// Proposes exposures from the frames of one window or scan: several exposures, or merged ones
/// (their sequence then says which they were), or one. From each pixel's modulation and its
/// brightest level, which both grow as the exposure, follows what any other would measure. A pixel
/// counts as lit whose modulation is five standard deviations of its noise. Throws Error where the
/// frames are not those of the sequence, no pixel is lit, or a need is out of range.
ExposureAdvice exposure_advice(const FrameViews& frames, const Sequence& sequence,
                               const ExposureNeeds& needs = {});

}  // namespace slipstream
