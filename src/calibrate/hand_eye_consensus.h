#pragma once

#include <optional>
#include <vector>

#include "calibrate/hand_eye.h"

namespace slipstream {

/// Whether each pair is used.
using Used = std::vector<bool>;

/// Calibrations that leave some poses out.
struct LeftOut {
  std::vector<HandEyePoses> poses;               ///< of each calibration
  std::vector<std::optional<PoseError>> errors;  ///< of the pairs; nullopt if not used
  std::vector<double> squares;  ///< of the errors in units of their covariance, over 6
};

/// The joint refinement of the pairs that agree.
struct RobustFit {
  Used used;
  AdjustedHandEye fit;
  std::optional<LeftOut> left_out;  ///< nullopt if too few poses are used
};

/// Refines the closed form, and drops the worst pairs as long as the others contradict them. Throws
/// Error if fewer than three in five pairs agree.
RobustFit robust_fit(const std::vector<PosePair>& pairs, const HandEyePoses& start, EyePlace place);

std::vector<PosePair> used_pairs(const std::vector<PosePair>& pairs, const Used& used);

/// Standard deviations of the camera's pose: of the fit, or of the jackknife where it is larger.
PoseError deviation_of(const RobustFit& found);

HandEyeError sizes_of(const PoseError& error);

}  // namespace slipstream
