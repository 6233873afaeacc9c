#pragma once

#include "check/frame_model.h"
#include "check/judged_scan.h"

namespace slipstream {

/// Standard deviations of the measuring band's phase, rad.
struct PhaseNoise {
  double of_level = 0;  ///< by noise, at a modulation of one grey level of 255
  double typical = 0;   ///< by noise, at the scan's median modulation
  double by_pixel = 0;  ///< as the light may be constant over each of the projector's pixels
};

/// By a few groups of samples; at least one is needed.
PhaseNoise phase_noise(const FrameModel& model, const JudgedScan& scan);

}  // namespace slipstream
