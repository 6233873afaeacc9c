#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "response/exposure_advice.h"
#include "slipstream/frame_set.h"
#include "slipstream/sequence.h"

namespace slipstream {

/// What exposures may be chosen; all times in the camera's unit.
struct ExposureLimits {
  double first = 1;  ///< to begin with
  double shortest = 0, longest = std::numeric_limits<double>::infinity();
  std::size_t most = 3;  ///< exposures of one scan, 1 to 3
  /// Longest sum of one scan's exposures, for each pattern.
  double total = std::numeric_limits<double>::infinity();
  /// Period of the room's light, or one that it shares with the projector's refreshes: exposures
  /// from half of it on are whole multiples; 0: steady light.
  double flicker_period = 0;
  /// The projector's: shorter exposures, from half of it on, are whole multiples; 0: unknown.
  double refresh_period = 0;
};

/// Exposures that measure nearly as many pixels as any.
struct ChosenExposures {
  std::vector<double> exposures{};  ///< in rising order
  double lit = 0;                   ///< see ExposureAdvice
  double measured = 0;              ///< predicted share of the lit pixels
  std::vector<double> tried{};      ///< in the order they were taken
};

/// Chooses exposures from a few scans: shorter and longer ones until the brightest pixels are not
/// saturated and longer ones show no more. `take`: the frames of one scan with that exposure.
/// `needs`: `limits` replaces its shortest and longest exposure. `goes_on`: false once the time for
/// it is over; the first scan is taken anyway. Throws Error if no exposure shows the patterns, and
/// as `take` does.
ChosenExposures choose_exposures(const std::function<FrameSet(double exposure)>& take,
                                 const Sequence& sequence, const ExposureLimits& limits,
                                 ExposureNeeds needs, const std::function<bool()>& goes_on);

/// The period, s, of the room's light, from the mean levels of frames of a still picture with their
/// times, s: 0.01 or 1/120 s, from mains of 50 or 60 Hz, or 0.05 s if either may be; nullopt if it
/// is steady within half a per cent, or the frames are too few or too regular to tell.
std::optional<double> flicker_period(const std::vector<double>& times,
                                     const std::vector<double>& levels);

}  // namespace slipstream
