#pragma once

#include <cstddef>
#include <optional>

#include "slipstream/codes/response.h"
#include "slipstream/response/scan_average.h"

namespace slipstream {

/// The linear patterns whose mean and modulation are those of the light that a response makes of
/// sinusoidal ones; its beta_p may be negative.
PatternLight linear_equivalent(const PatternLight& light, const Response& response);

/// How far frames are from what a linear response would show.
struct ResponseLinearity {
  int steps = 0;              ///< of the run that it was found with
  double second = 0;          ///< second harmonic, as a share of the first; 0 of a linear one
  double standard_error = 0;  ///< of that, if the pixels' errors are independent
  std::size_t pixels = 0;     ///< that were asked: lit, and never at either end of the grey levels
};

/// By the first run of 4 steps or more of the scans' patterns. None where there is no such run or
/// less than 100 pixels serve: three steps do not tell.
std::optional<ResponseLinearity> response_linearity(const ScanAverage& scans);

/// The second harmonic that so many steps show under a response, as a share of the first.
double second_harmonic(const PatternLight& light, const Response& response, int steps);

/// Whether the second harmonic is that share but for its error, and for what moves ambient light
/// by less than half a grey level.
bool has_second_harmonic(const ResponseLinearity& linearity, double share);

}  // namespace slipstream
