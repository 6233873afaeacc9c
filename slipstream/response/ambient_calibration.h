#pragma once

#include <optional>

#include "slipstream/base/image.h"
#include "slipstream/base/statistics.h"
#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/response.h"
#include "slipstream/response/scan_average.h"

namespace slipstream {

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

/// How the ambient light beta of Eq. (3.5) is spread over the pixels, grey levels.
struct AmbientEstimate {
  double mode = 0;  ///< where most pixels are: centre of mass of the fullest grey level
  double median = 0;
  double mean = 0;
  double variance = 0;
  std::size_t pixels = 0;
};

/// Beta of every pixel by Eqs. (3.5), (3.6); NaN where the reflectivity is below `least_alpha`,
/// because the noise of beta falls with it (3.42), or `measured` is 0. `mean` and `modulation` are
/// those of PMP, grey levels.
Image<double> ambient_map(const Image<double>& mean, const Image<double>& modulation,
                          const PatternLight& light, double least_alpha,
                          const Image<std::uint8_t>& measured);

/// Of the finite pixels of such a map. Throws Error where there are fewer than 100.
AmbientEstimate ambient_estimate(const Image<double>& map);

/// The ambient light that scans of a bright surface show.
struct AmbientCalibration {
  AmbientEstimate estimate{};
  Histogram histogram{};            ///< of the pixels' own, five standard deviations either side
  double least_reliable_alpha = 0;  ///< the reflectivity above which no frame is at zero, Eq. (3.9)
};

/// By the first band of the scans' patterns, Eq. (3.5), over the pixels whose reflectivity is at
/// least `least_alpha`, (0, 1]; with a response, by the mean and the modulation of the light that
/// it makes of the patterns. Throws Error for patterns with a cue in their frames, a least_alpha
/// out of range, too few pixels, or, where the scans have 4 steps or more, frames whose second
/// harmonic is not that of the response, or of a linear one where none is given.
AmbientCalibration calibrate_ambient(const ScanAverage& scans, double least_alpha = 0.5,
                                     const std::optional<Response>& response = std::nullopt);

/// Throws Error, naming the scan, where its patterns or exposures do not serve to measure ambient
/// light.
void require_ambient_measurable(const Scan& scan, const std::string& name);

}  // namespace slipstream
