#pragma once

#include <limits>
#include <vector>

#include "slipstream/frame_set.h"
#include "slipstream/sequence.h"

namespace slipstream {

/// Requirements for a valid pixel, grey levels of 255.
struct ExposureNeeds {
  double least_modulation = 15;  ///< above 0, up to 127
  double noise_variance = 1.6;   ///< sigma_w^2, >= 0, below 85^2
  /// Exposures that may be proposed, in the unit of the given ones.
  double shortest = 0, longest = std::numeric_limits<double>::infinity();
};

/// Predicted quality of the lit pixels for one exposure, or several merged.
struct ExposureChoice {
  std::vector<double> exposures{};  ///< in the unit of the given exposures
  double measured = 0;   ///< share that is unsaturated and has the least modulation, 0 to 1
  double saturated = 0;  ///< share saturated even in the shortest
  double too_dark = 0;   ///< share below the least modulation
  /// Standard deviation of the projector coordinate by Eq. (3.40) or (3.63), median of the measured
  /// pixels, fields; 0 without any.
  double sigma = 0;
};

struct ExposureAdvice {
  double lit = 0;  ///< share of all pixels that show the patterns, including saturated ones
  /// Share of the lit pixels that are saturated even in the shortest exposure taken: their level is
  /// unknown, and no choice counts them as measured.
  double unknown = 0;
  std::vector<ExposureChoice> taken{};     ///< each exposure alone, then all if several
  std::vector<ExposureChoice> proposed{};  ///< the best one, two and three
  /// Index of the proposal: the first to which one more exposure would add less than 2 % of the lit
  /// pixels.
  std::size_t best = 0;
  /// Factor on the patterns' brightness that makes the shortest exposure taken the best; 1 unless
  /// it is too long.
  double light = 1;
};

/// Proposes exposures from the frames of one window or scan: several exposures, merged ones (with
/// the original exposures in the sequence), or one. A pixel's modulation and brightest level, both
/// proportional to exposure, predict the result of any other. A pixel is lit if its modulation
/// exceeds five standard deviations of its noise. Throws Error if the frames do not match the
/// sequence, no pixel is lit, or a need is out of range.
ExposureAdvice exposure_advice(const FrameViews& frames, const Sequence& sequence,
                               const ExposureNeeds& needs = {});

}  // namespace slipstream
