#pragma once

#include <optional>

#include "slipstream/codes/response.h"
#include "slipstream/response/ambient_measurement.h"
#include "slipstream/response/measurement.h"
#include "slipstream/response/scan_average.h"

namespace slipstream {

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
