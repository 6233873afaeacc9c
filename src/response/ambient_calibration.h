#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/statistics.h"
#include "response/scan_average.h"
#include "slipstream/image.h"
#include "slipstream/pattern_set.h"
#include "slipstream/response.h"

namespace slipstream {

/// Deviation of frames from a linear response.
struct ResponseLinearity {
  int steps = 0;              ///< of the run used
  double second = 0;          ///< second harmonic as a fraction of the first; 0 if linear
  double standard_error = 0;  ///< of `second`, if the pixels' errors are independent
  std::size_t pixels = 0;     ///< used: lit, and never at either end of the grey levels
};

/// Uses the first run of 4 or more steps of the scans' patterns. Returns nullopt if there is no
/// such run, as three steps are not enough, or fewer than 100 usable pixels.
std::optional<ResponseLinearity> response_linearity(const ScanAverage& scans);

/// The second harmonic measured by `steps` steps under a response, as a fraction of the first.
double second_harmonic(const PatternLight& light, const Response& response, int steps);

/// Whether the second harmonic equals `share` within its error and a tolerance that shifts ambient
/// light by less than half a grey level.
bool has_second_harmonic(const ResponseLinearity& linearity, double share);

/// Distribution of the ambient light beta of Eq. (3.5) over the pixels, grey levels.
struct AmbientEstimate {
  double mode = 0;  ///< the most frequent value: centroid of the fullest grey level
  double median = 0, mean = 0, variance = 0;
  std::size_t pixels = 0;
};

/// Beta of every pixel by Eqs. (3.5), (3.6); NaN where the reflectivity is below `least_alpha`, as
/// low reflectivity makes beta noisy (3.42), or `measured` is 0. `mean` and `modulation` are from
/// PMP, grey levels.
Image<double> ambient_map(const Image<double>& mean, const Image<double>& modulation,
                          const PatternLight& light, double least_alpha,
                          const Image<std::uint8_t>& measured);

/// Statistics of the finite pixels of such a map. Throws Error if there are fewer than 100.
AmbientEstimate ambient_estimate(const Image<double>& map);

/// Ambient light measured on a bright surface.
struct AmbientCalibration {
  AmbientEstimate estimate{};
  Histogram histogram{};            ///< over the pixels, five standard deviations on either side
  double least_reliable_alpha = 0;  ///< reflectivity above which no frame is at zero, Eq. (3.9)
};

/// Uses the first band of the scans' patterns, Eq. (3.5), over pixels with a reflectivity of at
/// least `least_alpha`, (0, 1]; with a response, the mean and modulation of the light it produces
/// from the patterns. Throws Error for patterns with a cue in their frames, a least_alpha out of
/// range, too few pixels or, for 4 or more steps, frames whose second harmonic does not match the
/// response (by default linear).
AmbientCalibration calibrate_ambient(const ScanAverage& scans, double least_alpha = 0.5,
                                     const std::optional<Response>& response = std::nullopt);

/// Throws Error, beginning with `name`, if the scan's patterns or exposures are unsuitable for
/// measuring ambient light.
void require_ambient_measurable(const Scan& scan, const std::string& name);

}  // namespace slipstream
