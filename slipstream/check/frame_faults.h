#pragma once

#include <vector>

#include "slipstream/check/finding.h"
#include "slipstream/check/scan_samples.h"

namespace slipstream {

/// Frames that are the same picture, whole or in part, or black from some row on.
std::vector<Finding> damaged_frames(const ScanSamples& samples);

/// Frames without any pattern. A pattern that is dark wherever the scene is looks alike: to be
/// asked where the frames do not fit each other.
std::vector<Finding> dark_frames(const ScanSamples& samples);

/// What the light of a scan is judged by, beside its samples; grey levels of 255.
struct LightEvidence {
  int bits = 8;                  ///< as said
  double least_modulation = 15;  ///< of a point
  double modulation = 0;  ///< of the lit pixels, as of all the light in one sinusoid: the median
  double mean = 0;        ///< the median of the lit pixels' means over their frames
};

/// Light that no point can be measured in, or that spoils points: none, too little, too much, more
/// of the room's than of the projector's, fewer bits than said.
std::vector<Finding> light_faults(const ScanSamples& samples, const LightEvidence& light);

}  // namespace slipstream
